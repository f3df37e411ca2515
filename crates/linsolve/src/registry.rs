//! The names a dictionary may use, and what each becomes.

use std::fmt;

use granflow_base::Value;
use granflow_par::Exec;

use crate::amg;
use crate::bicgstab::BiCgStab;
use crate::csr::Csr;
use crate::incomplete::Incomplete;
use crate::iteration::Iteration;
use crate::pcg::ConjugateGradients;
use crate::precond::{Diagonal, Identity, Precond};
use crate::smooth::Sweeps;
use crate::solver::{LinearSolver, SolveError, Solved, Tolerance};

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The value of `solver`.
    Solver,
    /// The value of `preconditioner`.
    Preconditioner,
    /// The value of `smoother`.
    Smoother,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Solver => "solver",
            Kind::Preconditioner => "preconditioner",
            Kind::Smoother => "smoother",
        })
    }
}

/// One name of the registry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The word in the dictionary (that of OpenFOAM).
    pub name: &'static str,
    /// What it names.
    pub kind: Kind,
    /// The entry that does the work when this name is only an alias.
    pub mapped_onto: Option<&'static str>,
    /// Where the method is described.
    pub reference: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// A step of the method on `A x = b`, `r = b - A x`, `A = L + D + U`.
    pub formula: &'static str,
}

const fn entry(
    kind: Kind,
    name: &'static str,
    mapped_onto: Option<&'static str>,
    reference: &'static str,
    summary: &'static str,
    formula: &'static str,
) -> Entry {
    Entry { name, kind, mapped_onto, reference, summary, formula }
}

const TEMPLATES: &str = "Barrett et al., Templates for the Solution of Linear Systems, SIAM 1994";
const NOTAY: &str = "Notay, Electron. Trans. Numer. Anal. 37 (2010) 123";
const HESTENES: &str = "Hestenes and Stiefel, J. Res. Nat. Bur. Stand. 49 (1952) 409";
const VORST: &str = "van der Vorst, SIAM J. Sci. Stat. Comput. 13 (1992) 631";

const CG: &str = "x += a p, r -= a A p, z = M^-1 r, p = z + (r'.z'/r.z) p; a = r.z/p.A p, ' after";
const BICG: &str = "v = A M^-1 p, s = r - a v, t = A M^-1 s, x += M^-1 (a p + w s), r = s - w t; \
                    a = r0.r/r0.v, w = t.s/t.t, p = r + b (p - w v), b = (a/w) r0.r'/r0.r";
const ICD: &str = "z = (D' + U)^-1 D' (D' + L)^-1 r, D'_i = a_ii - sum_{j<i} a_ij^2/D'_j";
const ILUD: &str = "z = (D' + U)^-1 D' (D' + L)^-1 r, D'_i = a_ii - sum_{j<i} a_ij a_ji/D'_j";
const GS: &str = "x <- x + (D + L)^-1 (b - A x), then x <- x + (D + U)^-1 (b - A x)";

const CYCLE: &str = "z = cycle(r): smooth z, e = A_c^-1 P^T (r - A z) by a cycle on fewer unknowns, z += P e, \
                     smooth z; A_c = P^T A P, P: 1 where a cell is of an aggregate";
const CYCLES: &str = "PCG or PBiCGStab with M^-1 r = cycle(r)";

/// Every known name.
#[rustfmt::skip]
pub const ALL: &[Entry] = {
    use Kind::{Preconditioner as P, Smoother as M, Solver as S};
    &[
        entry(S, "PCG", None, HESTENES, "conjugate gradients, symmetric matrices", CG),
        entry(S, "PBiCGStab", None, VORST, "stabilised bi-conjugate gradients, any matrix", BICG),
        entry(S, "PBiCG", Some("PBiCGStab"), VORST, "served by PBiCGStab", BICG),
        entry(S, "GAMG", None, NOTAY, "Krylov iteration preconditioned by aggregation multigrid", CYCLES),
        entry(S, "smoothSolver", None, TEMPLATES, "sweeps of a smoother", "x <- x + M^-1 (b - A x), M the smoother's"),
        entry(S, "diagonal", None, TEMPLATES, "division by the diagonal, iterated", "x <- x + D^-1 (b - A x)"),
        entry(P, "DIC", None, TEMPLATES, "incomplete Cholesky, diagonal only", ICD),
        entry(P, "FDIC", Some("DIC"), TEMPLATES, "served by DIC", ICD),
        entry(P, "DILU", None, TEMPLATES, "incomplete LU, diagonal only", ILUD),
        entry(P, "diagonal", None, TEMPLATES, "division by the diagonal", "z = D^-1 r"),
        entry(P, "none", None, TEMPLATES, "no preconditioning", "z = r"),
        entry(P, "GAMG", None, NOTAY, "one cycle of aggregation multigrid", CYCLE),
        entry(M, "symGaussSeidel", None, TEMPLATES, "symmetric Gauss-Seidel, coloured in fixed blocks", GS),
        entry(M, "GaussSeidel", Some("symGaussSeidel"), TEMPLATES, "served by symGaussSeidel", GS),
        entry(M, "nonBlockingGaussSeidel", Some("symGaussSeidel"), TEMPLATES, "served by symGaussSeidel", GS),
        entry(M, "DIC", None, TEMPLATES, "a step with incomplete Cholesky", "x <- x + z, z as of the preconditioner DIC"),
        entry(M, "FDIC", Some("DIC"), TEMPLATES, "served by DIC", "x <- x + z, z as of the preconditioner DIC"),
        entry(M, "DILU", None, TEMPLATES, "a step with incomplete LU", "x <- x + z, z as of the preconditioner DILU"),
        entry(M, "DICGaussSeidel", Some("symGaussSeidel"), TEMPLATES, "served by symGaussSeidel", GS),
        entry(M, "DILUGaussSeidel", Some("symGaussSeidel"), TEMPLATES, "served by symGaussSeidel", GS),
    ]
};

/// The three words that choose a solver.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SolverSpec {
    /// `solver`.
    pub solver: String,
    /// `preconditioner` of a Krylov solver; `None` takes DIC or DILU.
    pub preconditioner: Option<String>,
    /// `smoother` of smoothSolver, `None` takes symGaussSeidel. GAMG has its own.
    pub smoother: Option<String>,
}

/// A word that names nothing known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// What it should name.
    pub kind: Kind,
    /// The word.
    pub word: String,
}

impl Unknown {
    /// The names that would do.
    pub fn known(&self) -> impl Iterator<Item = &'static str> {
        let kind = self.kind;
        ALL.iter().filter(move |e| e.kind == kind).map(|e| e.name)
    }
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known: Vec<&str> = self.known().collect();
        write!(f, "unknown {} `{}`, known are {}", self.kind, self.word, known.join(", "))
    }
}
impl std::error::Error for Unknown {}

/// The entry that does the work of `word`.
fn resolve(kind: Kind, word: &str) -> Result<&'static str, Unknown> {
    let found = ALL.iter().find(|e| e.kind == kind && e.name == word);
    let unknown = || Unknown { kind, word: word.to_string() };
    found.map(|e| e.mapped_onto.unwrap_or(e.name)).ok_or_else(unknown)
}

fn precond<T: Value>(kind: Kind, word: &str) -> Result<Box<dyn Precond<T>>, Unknown> {
    Ok(match resolve(kind, word)? {
        "DIC" | "DILU" => Box::<Incomplete>::default(),
        "diagonal" => Box::<Diagonal>::default(),
        "GAMG" => amg::multigrid(),
        "symGaussSeidel" => amg::gauss_seidel(),
        _ => Box::<Identity>::default(),
    })
}

/// Makes the solver that `spec` describes.
///
/// # Errors
/// [`Unknown`] names the first word that is not in [`ALL`]; words that the solver does not use are
/// checked too.
pub fn build<T: Value>(spec: &SolverSpec) -> Result<Box<dyn LinearSolver<T>>, Unknown> {
    let solver = resolve(Kind::Solver, &spec.solver)?;
    let preconditioner = spec.preconditioner.as_deref().unwrap_or("DILU");
    let preconditioner = precond(Kind::Preconditioner, preconditioner)?;
    let smoother = spec.smoother.as_deref().unwrap_or("symGaussSeidel");
    let smoother = precond(Kind::Smoother, smoother)?;
    Ok(match solver {
        "PCG" => Box::new(Iteration::<T, ConjugateGradients<T>>::new("PCG", preconditioner)),
        "PBiCGStab" => Box::new(Iteration::<T, BiCgStab<T>>::new("PBiCGStab", preconditioner)),
        "GAMG" => gamg(),
        "smoothSolver" => Box::new(Iteration::<T, Sweeps>::new("smoothSolver", smoother)),
        _ => Box::new(Iteration::<T, Sweeps>::new("diagonal", Box::<Diagonal>::default())),
    })
}

/// Multigrid for any matrix: conjugate gradients outside when it is symmetric (looked at on every
/// refresh), else stabilised bi-conjugate gradients.
pub fn gamg<T: Value>() -> Box<dyn LinearSolver<T>> {
    Box::new(Gamg {
        cg: Iteration::new("GAMG", amg::multigrid()),
        stab: Iteration::new("GAMG", amg::multigrid()),
        rescue: Iteration::new("GAMG", Box::<Incomplete>::default()),
        symmetric: None,
        u: Vec::new(),
        v: Vec::new(),
    })
}

struct Gamg<T: Value> {
    cg: Iteration<T, ConjugateGradients<T>>,
    stab: Iteration<T, BiCgStab<T>>,
    /// In double precision throughout: takes over where coefficients vary so much that the
    /// hierarchy's single precision loses positivity.
    rescue: Iteration<T, BiCgStab<T>>,
    symmetric: Option<bool>,
    u: Vec<f64>,
    v: Vec<f64>,
}

impl<T: Value> LinearSolver<T> for Gamg<T> {
    fn name(&self) -> &'static str {
        "GAMG"
    }
    fn refresh(&mut self, exec: &Exec, a: &Csr) -> Result<(), SolveError> {
        let symmetric = a.is_symmetric(exec, &mut self.u, &mut self.v);
        self.symmetric = Some(symmetric);
        if symmetric { self.cg.refresh(exec, a) } else { self.stab.refresh(exec, a) }
    }
    fn solve(
        &mut self,
        exec: &Exec,
        a: &Csr,
        b: &[T],
        x: &mut [T],
        tol: &Tolerance,
    ) -> Result<Solved, SolveError> {
        if self.symmetric.is_none() {
            self.refresh(exec, a)?;
        }
        let solved = match self.symmetric {
            Some(false) => self.stab.solve(exec, a, b, x, tol),
            _ => self.cg.solve(exec, a, b, x, tol),
        };
        match solved {
            Err(SolveError::NotPositiveDefinite { .. }) => {
                self.rescue.refresh(exec, a)?;
                self.rescue.solve(exec, a, b, x, tol)
            }
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_builds_and_every_alias_leads_somewhere() {
        for e in ALL {
            if let Some(to) = e.mapped_onto {
                assert!(
                    ALL.iter().any(|o| o.kind == e.kind && o.name == to && o.mapped_onto.is_none())
                );
            }
            let mut spec = SolverSpec { solver: "PCG".into(), ..SolverSpec::default() };
            match e.kind {
                Kind::Solver => spec.solver = e.name.into(),
                Kind::Preconditioner => spec.preconditioner = Some(e.name.into()),
                Kind::Smoother => spec.smoother = Some(e.name.into()),
            }
            assert!(build::<f64>(&spec).is_ok() && build::<[f64; 3]>(&spec).is_ok(), "{}", e.name);
        }
    }

    #[test]
    fn an_unknown_word_is_named_with_the_choices() {
        let spec = SolverSpec { solver: "PGC".into(), ..SolverSpec::default() };
        let message = build::<f64>(&spec).err().map(|e| e.to_string()).unwrap_or_default();
        assert_eq!(
            message,
            "unknown solver `PGC`, known are PCG, PBiCGStab, PBiCG, GAMG, smoothSolver, diagonal"
        );
    }
}
