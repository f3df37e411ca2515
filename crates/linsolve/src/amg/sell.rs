//! A part of a level's matrix in slices of 16 rows (SELL-C, Kreutzer et al. 2014): entry `k` of
//! all 16 rows side by side, so that plain loops become vector instructions.

use granflow_par::{Exec, gather};

use super::graph::{NONE, clear};
use super::layout::LANES;

/// Couplings `(column, entry of the graph)` of each row of a slice.
pub(crate) type Lanes<C> = [Vec<(C, u32)>; LANES];

/// Couplings by slices; `C` is the type of a column.
#[derive(Debug, Default)]
pub(crate) struct Sell<C> {
    /// Groups of entries `ptr[s]..ptr[s + 1]` belong to slice `s`.
    ptr: Vec<u32>,
    col: Vec<[C; LANES]>,
    val: Vec<[f32; LANES]>,
    src: Vec<[u32; LANES]>,
}

impl<C: Copy + Default> Sell<C> {
    /// Empties it, for `slices` slices of some of `entries` couplings.
    pub(crate) fn begin(&mut self, slices: usize, entries: usize) {
        // Memory that is not written costs nothing.
        let groups = 2 * entries / LANES + slices;
        clear(&mut self.ptr, slices + 1);
        self.ptr.push(0);
        clear(&mut self.col, groups);
        clear(&mut self.val, groups);
        clear(&mut self.src, groups);
    }
    /// Appends a slice of the couplings `(column, entry of the graph)` of each lane.
    pub(crate) fn push(&mut self, lanes: &Lanes<C>, own: impl Fn(usize) -> C) {
        let width = lanes.iter().map(Vec::len).max().unwrap_or(0);
        for k in 0..width {
            // Padding points at the row itself, which is in the cache anyway.
            let at = |lane: usize| lanes[lane].get(k).copied().unwrap_or((own(lane), NONE));
            self.col.push(std::array::from_fn(|lane| at(lane).0));
            self.src.push(std::array::from_fn(|lane| at(lane).1));
            self.val.push([0.0; LANES]);
        }
        self.ptr.push(self.col.len() as u32);
    }
    pub(crate) fn refresh(&mut self, exec: &Exec, val: &[f32]) {
        let src = &self.src;
        exec.for_each(&mut self.val, |first, out| {
            for (o, s) in out.iter_mut().zip(&src[first..]) {
                for lane in 0..LANES {
                    o[lane] = if s[lane] == NONE { 0.0 } else { val[s[lane] as usize] };
                }
            }
        });
    }
}

impl<C: Copy + Into<u32>> Sell<C> {
    /// `d -= ` sums of the rows of slice `s`.
    pub(crate) fn diagonal(&self, s: usize, d: &mut [f64; LANES]) {
        for val in &self.val[self.ptr[s] as usize..self.ptr[s + 1] as usize] {
            (0..LANES).for_each(|lane| d[lane] -= f64::from(val[lane]));
        }
    }
    /// `acc -= (slice s) z`.
    #[inline(always)]
    pub(crate) fn subtract<const N: usize>(
        &self,
        s: usize,
        z: &[[f32; N]],
        acc: &mut [[f32; N]; LANES],
    ) {
        let r = self.ptr[s] as usize..self.ptr[s + 1] as usize;
        for (col, val) in self.col[r.clone()].iter().zip(&self.val[r]) {
            let zs = gather(z, col);
            for lane in 0..LANES {
                for c in 0..N {
                    acc[lane][c] -= val[lane] * zs[lane][c];
                }
            }
        }
    }
    /// `acc += (slice s) (z - own)`, where `own` is `z` in the slice itself: what flows between
    /// rows, which rounds to the same number on both sides.
    #[inline(always)]
    pub(crate) fn flow<const N: usize>(
        &self,
        s: usize,
        z: &[[f32; N]],
        own: &[[f32; N]; LANES],
        acc: &mut [[f32; N]; LANES],
    ) {
        let r = self.ptr[s] as usize..self.ptr[s + 1] as usize;
        for (col, val) in self.col[r.clone()].iter().zip(&self.val[r]) {
            let zs = gather(z, col);
            for lane in 0..LANES {
                for c in 0..N {
                    acc[lane][c] += val[lane] * (zs[lane][c] - own[lane][c]);
                }
            }
        }
    }
}
