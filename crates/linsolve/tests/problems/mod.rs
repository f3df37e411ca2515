//! The problem set that every solver is held against: 7-point matrices on a box of cells.
#![allow(dead_code, unreachable_pub)]

use std::sync::Arc;

use granflow_linsolve::Csr;
use granflow_par::{Halo, Link};

/// A box of cells and what surrounds it.
#[derive(Clone, Copy)]
pub struct Grid {
    pub n: [usize; 3],
    /// Fixed values all round; otherwise no flux (singular).
    pub fixed: bool,
    /// Periodic in x through ghosts.
    pub periodic: bool,
}

impl Grid {
    pub fn cube(n: usize) -> Grid {
        Grid { n: [n; 3], fixed: true, periodic: false }
    }
    pub fn cells(&self) -> usize {
        self.n.iter().product()
    }
    pub fn index(&self, c: [usize; 3]) -> usize {
        c[0] + self.n[0] * (c[1] + self.n[1] * c[2])
    }
    pub fn coords(&self, i: usize) -> [usize; 3] {
        [i % self.n[0], i / self.n[0] % self.n[1], i / self.n[0] / self.n[1]]
    }
}

/// A number in 0..1 without pattern.
pub fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bd1_e995;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// `-div(k grad)` with `k` per cell (harmonic mean on faces), scaled by `aniso` per direction.
/// `wind` adds upwind convection along x: an unsymmetric M-matrix.
pub fn matrix(g: Grid, k: impl Fn([usize; 3]) -> f64, aniso: [f64; 3], wind: f64) -> Csr {
    let n = g.cells();
    let (mut ptr, mut col, mut val, mut diag) = (vec![0u32], vec![], vec![], vec![]);
    let mut low = Vec::new();
    let mut high = Vec::new();
    let ghosts = if g.periodic { 2 * g.n[1] * g.n[2] } else { 0 };
    for i in 0..n {
        let c = g.coords(i);
        let here = k(c);
        let at = col.len();
        diag.push(at as u32);
        col.push(i as u32);
        val.push(0.0);
        for d in 0..3 {
            for side in [-1isize, 1] {
                let to = c[d] as isize + side;
                let inside = to >= 0 && to < g.n[d] as isize;
                let mut o = c;
                let column = if inside {
                    o[d] = to as usize;
                    Some(g.index(o) as u32)
                } else if g.periodic && d == 0 {
                    o[0] = if side < 0 { g.n[0] - 1 } else { 0 };
                    let line = c[1] + g.n[1] * c[2];
                    let half = if side < 0 { 0 } else { ghosts / 2 };
                    Some((n + half + line) as u32)
                } else {
                    None
                };
                let there = k(o);
                let face = aniso[d] * 2.0 * here * there / (here + there);
                let upwind = if d == 0 && side < 0 { wind } else { 0.0 };
                if let Some(column) = column {
                    col.push(column);
                    val.push(-face - upwind);
                    val[at] += face + upwind;
                } else if g.fixed {
                    val[at] += 2.0 * aniso[d] * here + upwind;
                }
            }
        }
        if c[0] == 0 {
            low.push(i as u32);
        }
        if c[0] == g.n[0] - 1 {
            high.push(i as u32);
        }
        ptr.push(col.len() as u32);
    }
    let mut a = Csr::scalar(ptr, col, val, diag);
    if g.periodic {
        let half = ghosts / 2;
        let halo = Halo::new(vec![
            Link { rank: 0, send: high, recv: n..n + half, rotation: None },
            Link { rank: 0, send: low, recv: n + half..n + ghosts, rotation: None },
        ]);
        a.image = Arc::new(halo.local_image(0, ghosts));
        a.halo = Arc::new(halo);
    }
    a
}

/// Named matrices: `a`, `b`, `c` as in the project's table of pressure solves.
pub fn laplacian(g: Grid) -> Csr {
    matrix(g, |_| 1.0, [1.0; 3], 0.0)
}
/// 1/rho with a 1000:1 interface (a wavy surface).
pub fn interface(g: Grid) -> Csr {
    let wave = move |c: [usize; 3]| {
        let x = |d: usize| (c[d] as f64 + 0.5) / g.n[d] as f64;
        if x(2) < 0.5 + 0.2 * (6.0 * x(0)).sin() * (5.0 * x(1)).cos() { 1e-3 } else { 1.0 }
    };
    matrix(g, wave, [1.0; 3], 0.0)
}
/// Viscosity-like: six decades, smooth with a random part of one decade, and a few cells
/// at random over all six.
pub fn viscous(g: Grid) -> Csr {
    let k = move |c: [usize; 3]| {
        let x = |d: usize| (c[d] as f64 + 0.5) / g.n[d] as f64;
        let i = g.index(c);
        let smooth = 3.0 + 2.5 * (7.0 * x(0)).sin() * (5.0 * x(1)).cos() * (3.0 * x(2)).cos();
        let spots = if noise(i + 77) < 0.02 { 6.0 * noise(i + 1234) } else { smooth };
        10f64.powf(spots + 0.5 * noise(i))
    };
    matrix(g, k, [1.0; 3], 0.0)
}
/// Thin cells: couplings along z 1e4 times those along x and y.
pub fn thin(g: Grid) -> Csr {
    matrix(g, |_| 1.0, [1.0, 1.0, 1e4], 0.0)
}

/// A right-hand side without pattern.
pub fn rhs(n: usize) -> Vec<f64> {
    (0..n).map(|i| noise(i) - 0.5).collect()
}
/// The same with mean zero.
pub fn balanced(n: usize) -> Vec<f64> {
    let mut b = rhs(n);
    let mean = b.iter().sum::<f64>() / n as f64;
    b.iter_mut().for_each(|b| *b -= mean);
    b
}

/// How the coefficient of a [`hard`] problem varies over its six decades.
type Decades = fn(Grid, [usize; 3]) -> f64;

/// Thin cells with coefficients over six decades, with and without a diagonal of its own size in
/// each cell: `c_i p_i - div(k grad p)`, as an implicit pressure with viscous stress has.
pub fn hard() -> Vec<(String, Csr)> {
    let smooth: Decades = |g, c| {
        let x = |d: usize| (c[d] as f64 + 0.5) / g.n[d] as f64;
        3.0 + 3.0 * (7.0 * x(0)).sin() * (5.0 * x(1)).cos() * (3.0 * x(2)).cos()
    };
    let random: Decades = |g, c| 6.0 * noise(g.index(c) + 555);
    let grids = [
        ("plane", [64, 64, 1], vec![[1e4, 1.0, 0.0], [1.0, 1e4, 0.0], [1e2, 1.0, 0.0]]),
        ("box", [24, 22, 20], vec![[1.0, 1.0, 1e4], [1e4, 1.0, 1.0], [1e4, 1e4, 1.0]]),
        ("sector", [16, 5, 3], vec![[1e4, 1.0, 1.0], [1.0, 1e4, 1.0], [1.0, 1e2, 1e4]]),
    ];
    let mut all = Vec::new();
    for (shape, n, stretches) in grids {
        for aniso in stretches {
            for (kind, decades) in [("smooth", smooth), ("random", random)] {
                for (ends, fixed, shift) in [
                    ("fixed", true, 0),
                    ("free", false, 0),
                    ("weak", false, 1),
                    ("mixed", false, 2),
                ] {
                    let g = Grid { n, fixed, periodic: false };
                    let mut a = matrix(g, |c| 10f64.powf(decades(g, c)), aniso, 0.0);
                    for i in 0..a.rows() {
                        let wave = 10f64.powf(4.0 * (0.37 * i as f64).sin());
                        let d = &mut a.val[a.diag[i] as usize];
                        *d += [0.0, 1e-5 * wave * *d, wave][shift];
                    }
                    all.push((format!("{shape} {aniso:?} {kind} {ends}"), a));
                }
            }
        }
    }
    for (kind, decades) in [("smooth", smooth), ("random", random)] {
        for fixed in [true, false] {
            all.push((format!("rings {kind} {fixed}"), rings(fixed, decades)));
        }
    }
    all
}

/// A mesh in r and z whose cells grow from an aspect ratio of 10 to one of 100.
fn rings(fixed: bool, decades: Decades) -> Csr {
    let g = Grid { n: [48, 40, 1], fixed, periodic: false };
    let mut a = matrix(g, |c| 10f64.powf(decades(g, c)), [1.0, 1.0, 0.0], 0.0);
    let height = |j: usize| 0.01 * 10f64.powf(j as f64 / 39.0);
    for i in 0..a.rows() {
        let c = g.coords(i);
        // What the fixed values around add stays; free ends add nothing.
        let mut rest = 0.0;
        let row = a.ptr[i] as usize..a.ptr[i + 1] as usize;
        if fixed && row.len() < 5 {
            rest = a.val[row.clone()].iter().sum::<f64>();
        }
        for k in row {
            let o = g.coords(a.col[k] as usize);
            if a.col[k] as usize == i {
                continue;
            }
            let r = 0.5 * (c[0] + o[0]) as f64 + 0.5;
            let factor = match c[1] == o[1] {
                true => r * height(c[1]),
                false => r / (0.5 * (height(c[1]) + height(o[1]))),
            };
            a.val[k] *= factor;
            rest -= a.val[k];
        }
        a.val[a.diag[i] as usize] = rest;
    }
    a
}
