//! One level: its matrix in slots, and the sweeps over it.

use std::cmp::Ordering;

use granflow_par::{Exec, wide};

use super::graph::{Galerkin, Graph, NONE, clear, fill};
use super::layout::{LANES, Layout, SLOTS};
use super::sell::{Lanes, Sell};

/// A vector of a level, in slots.
pub(crate) type Slots<const N: usize> = Vec<[f32; N]>;

/// Matrix and order of a level; split by what a Gauss-Seidel sweep needs apart.
#[derive(Debug, Default)]
pub(crate) struct Matrix {
    pub(crate) layout: Layout,
    /// Couplings to earlier and to later slices of the block (column: slot within the block).
    lower: Sell<u16>,
    upper: Sell<u16>,
    /// Couplings to other blocks.
    outer: Sell<u32>,
    /// Row sums and reciprocal diagonals.
    sum: Vec<f32>,
    inv: Vec<f32>,
    /// Of the slice that is being built.
    lanes: (Lanes<u16>, Lanes<u16>, Lanes<u32>),
}

impl Matrix {
    /// Takes up the pattern of `g`; the rows in `order` are cut into blocks.
    pub(crate) fn build(&mut self, g: &Graph, order: &[u32]) {
        let Matrix { layout, lower, upper, outer, sum, inv, lanes: (lo, up, out) } = self;
        layout.build(g, order);
        let slots = layout.row.len();
        let (slices, entries) = (slots / LANES, g.col.len());
        lower.begin(slices, entries);
        upper.begin(slices, entries);
        outer.begin(slices, entries);
        for (s, rows) in layout.row.chunks_exact(LANES).enumerate() {
            lo.iter_mut().for_each(Vec::clear);
            up.iter_mut().for_each(Vec::clear);
            out.iter_mut().for_each(Vec::clear);
            for (lane, &i) in rows.iter().enumerate().filter(|(_, i)| **i != NONE) {
                for k in g.entries(i as usize) {
                    if g.col[k] == NONE {
                        continue;
                    }
                    let to = layout.slot[g.col[k] as usize] as usize;
                    let within = (to % SLOTS) as u16;
                    let same = to / SLOTS == s * LANES / SLOTS;
                    match (to / LANES).cmp(&s) {
                        Ordering::Less if same => lo[lane].push((within, k as u32)),
                        Ordering::Greater if same => up[lane].push((within, k as u32)),
                        _ => out[lane].push((to as u32, k as u32)),
                    }
                }
            }
            let own = |lane: usize| ((s * LANES + lane) % SLOTS) as u16;
            lower.push(lo, own);
            upper.push(up, own);
            outer.push(out, |lane| (s * LANES + lane) as u32);
        }
        fill(sum, slots, 0.0);
        fill(inv, slots, 0.0);
    }

    pub(crate) fn slots(&self) -> usize {
        self.sum.len()
    }

    pub(crate) fn refresh(&mut self, exec: &Exec, g: &Graph) {
        self.lower.refresh(exec, &g.val);
        self.upper.refresh(exec, &g.val);
        self.outer.refresh(exec, &g.val);
        let Matrix { layout, lower, upper, outer, sum, inv, .. } = self;
        exec.for_each(sum, |first, sum| {
            for (s, &i) in sum.iter_mut().zip(&layout.row[first..]) {
                *s = if i == NONE { 0.0 } else { g.sum[i as usize] };
            }
        });
        exec.for_each_block(inv, SLOTS, |first, inv| {
            for (k, inv) in inv.chunks_exact_mut(LANES).enumerate() {
                let at = first + k * LANES;
                let mut d: [f64; LANES] = std::array::from_fn(|lane| f64::from(sum[at + lane]));
                lower.diagonal(at / LANES, &mut d);
                upper.diagonal(at / LANES, &mut d);
                outer.diagonal(at / LANES, &mut d);
                for (inv, d) in inv.iter_mut().zip(d) {
                    // A null row is one of a singular system's pieces shrunk to a point (or no
                    // row): left alone.
                    let one_over = 1.0 / d as f32;
                    *inv = if one_over.is_finite() { one_over } else { 0.0 };
                }
            }
        });
    }

    /// `z = (D + L)^-1 b`: a forward sweep from zero.
    pub(crate) fn forward<const N: usize>(&self, exec: &Exec, b: &[[f32; N]], z: &mut [[f32; N]]) {
        exec.for_each_block(z, SLOTS, |first, z| {
            wide(
                #[inline(always)]
                || {
                    for s in 0..z.len() / LANES {
                        let at = first + s * LANES;
                        let mut acc = lanes(b, at);
                        self.lower.subtract(at / LANES, z, &mut acc);
                        self.divide(at, &acc, &mut z[s * LANES..]);
                    }
                },
            )
        });
    }
    /// `z -= D^-1 U z` from the back: turns a forward sweep into a symmetric one.
    pub(crate) fn backward<const N: usize>(&self, exec: &Exec, z: &mut [[f32; N]]) {
        exec.for_each_block(z, SLOTS, |first, z| {
            wide(
                #[inline(always)]
                || {
                    for s in (0..z.len() / LANES).rev() {
                        let at = first + s * LANES;
                        let mut acc = [[0.0; N]; LANES];
                        self.upper.subtract(at / LANES, z, &mut acc);
                        for lane in 0..LANES {
                            for c in 0..N {
                                z[s * LANES + lane][c] += acc[lane][c] * self.inv[at + lane];
                            }
                        }
                    }
                },
            )
        });
    }
    /// `r = b - A z` right after [`Matrix::forward`], where it is `-(U + O) z`.
    pub(crate) fn left_over<const N: usize>(
        &self,
        exec: &Exec,
        z: &[[f32; N]],
        r: &mut [[f32; N]],
    ) {
        exec.for_each_block(r, SLOTS, |first, r| {
            wide(
                #[inline(always)]
                || {
                    let block = &z[first..first + r.len()];
                    for s in 0..r.len() / LANES {
                        let mut acc = [[0.0; N]; LANES];
                        self.upper.subtract(first / LANES + s, block, &mut acc);
                        self.outer.subtract(first / LANES + s, z, &mut acc);
                        r[s * LANES..(s + 1) * LANES].copy_from_slice(&acc);
                    }
                },
            )
        });
    }
    /// A backward Gauss-Seidel sweep on `A z = b`; `t` is scratch.
    pub(crate) fn sweep_back<const N: usize>(
        &self,
        exec: &Exec,
        b: &[[f32; N]],
        z: &mut [[f32; N]],
        t: &mut [[f32; N]],
    ) {
        let old = &*z;
        exec.for_each_block(t, SLOTS, |first, t| {
            wide(
                #[inline(always)]
                || {
                    for s in 0..t.len() / LANES {
                        let at = first + s * LANES;
                        let mut acc = lanes(b, at);
                        self.outer.subtract(at / LANES, old, &mut acc);
                        t[s * LANES..(s + 1) * LANES].copy_from_slice(&acc);
                    }
                },
            )
        });
        let t = &*t;
        exec.for_each_block(z, SLOTS, |first, z| {
            wide(
                #[inline(always)]
                || {
                    for s in (0..z.len() / LANES).rev() {
                        let at = first + s * LANES;
                        let mut acc = lanes(t, at);
                        self.lower.subtract(at / LANES, z, &mut acc);
                        self.upper.subtract(at / LANES, z, &mut acc);
                        self.divide(at, &acc, &mut z[s * LANES..]);
                    }
                },
            )
        });
    }
    /// `v = A z`; returns what `sums` makes of each block (first slot, block of `v`). Formed from
    /// differences of `z`: where couplings differ by many decades, the strong ones would else leave
    /// more rounding behind than the weak ones amount to.
    pub(crate) fn times<const N: usize, const K: usize>(
        &self,
        exec: &Exec,
        z: &[[f32; N]],
        v: &mut [[f32; N]],
        sums: impl Fn(usize, &[[f32; N]]) -> [f64; K] + Sync,
    ) -> [f64; K] {
        exec.for_each_local_sums(v, |first, v| {
            wide(
                #[inline(always)]
                || {
                    for s in 0..v.len() / LANES {
                        let at = first + s * LANES;
                        let start = at / SLOTS * SLOTS;
                        let block = &z[start..(start + SLOTS).min(z.len())];
                        let own = lanes(z, at);
                        let mut acc = own;
                        for (z, sum) in acc.iter_mut().zip(&self.sum[at..]) {
                            *z = z.map(|z| z * sum);
                        }
                        self.lower.flow(at / LANES, block, &own, &mut acc);
                        self.upper.flow(at / LANES, block, &own, &mut acc);
                        self.outer.flow(at / LANES, z, &own, &mut acc);
                        v[s * LANES..(s + 1) * LANES].copy_from_slice(&acc);
                    }
                },
            );
            sums(first, v)
        })
    }

    #[inline(always)]
    fn divide<const N: usize>(&self, at: usize, acc: &[[f32; N]; LANES], z: &mut [[f32; N]]) {
        let (z, inv) = (&mut z[..LANES], &self.inv[at..at + LANES]);
        for lane in 0..LANES {
            for c in 0..N {
                z[lane][c] = acc[lane][c] * inv[lane];
            }
        }
    }
}

#[inline(always)]
fn lanes<const N: usize>(b: &[[f32; N]], at: usize) -> [[f32; N]; LANES] {
    let b = &b[at..at + LANES];
    std::array::from_fn(|lane| b[lane])
}

/// From a level to the next coarser one.
#[derive(Debug, Default)]
pub(crate) struct Transfer {
    pub(crate) galerkin: Galerkin,
    /// Coarse slot of each fine slot, [`NONE`] for none.
    parent: Vec<u32>,
    /// Fine slots of each coarse slot.
    ptr: Vec<u32>,
    child: Vec<u32>,
}

impl Transfer {
    /// Puts into slots what the aggregates say about rows. `coarse_row` is the row in each coarse
    /// slot, `coarse_slot` the inverse.
    pub(crate) fn place(
        &mut self,
        fine: &Layout,
        aggregate: &[u32],
        coarse_row: &[u32],
        coarse_slot: &[u32],
    ) {
        let Transfer { galerkin, parent, ptr, child } = self;
        clear(parent, fine.row.len());
        parent.extend(fine.row.iter().map(|&i| match i {
            NONE => NONE,
            i if aggregate[i as usize] == NONE => NONE,
            i => coarse_slot[aggregate[i as usize] as usize],
        }));
        clear(ptr, coarse_row.len() + 1);
        clear(child, fine.slot.len());
        ptr.push(0);
        for &i in coarse_row {
            if i != NONE {
                child.extend(
                    galerkin.children.of(i as usize).iter().map(|&c| fine.slot[c as usize]),
                );
            }
            ptr.push(child.len() as u32);
        }
    }
    /// `coarse = P^T fine`.
    pub(crate) fn restrict<const N: usize>(
        &self,
        exec: &Exec,
        fine: &[[f32; N]],
        coarse: &mut [[f32; N]],
    ) {
        exec.for_each(coarse, |first, coarse| {
            for (i, out) in coarse.iter_mut().enumerate() {
                let own = self.ptr[first + i] as usize..self.ptr[first + i + 1] as usize;
                let mut s = [0.0; N];
                for &c in &self.child[own] {
                    (0..N).for_each(|k| s[k] += fine[c as usize][k]);
                }
                *out = s;
            }
        });
    }
    /// `fine += P coarse`.
    pub(crate) fn prolong<const N: usize>(
        &self,
        exec: &Exec,
        coarse: &[[f32; N]],
        fine: &mut [[f32; N]],
    ) {
        exec.for_each(fine, |first, fine| {
            for (out, &p) in fine.iter_mut().zip(&self.parent[first..]) {
                if p != NONE {
                    (0..N).for_each(|k| out[k] += coarse[p as usize][k]);
                }
            }
        });
    }
}
