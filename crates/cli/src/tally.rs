//! What a run has done so far, and what there is to say about it at the end.

use crate::session::Session;
use crate::text::{count, duration, number, place, residual, rounded};
use granflow_case::config::Solution;
use granflow_case::{Case, Shortened, StepEvent, Tensile};
use granflow_flow::{Residuals, SolveCount};
use granflow_physics::rheology::{Beyond, Posedness};
use std::path::Path;

/// Counts over the steps of a run.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) steps: usize,
    unconverged: usize,
    began_at: f64,
    /// Residuals of the last step, and that of the fluidity's equation, if it ended in a steady state.
    steady: Option<(Residuals, Option<f64>)>,
    /// Time, length and relative change of velocity of the last full step.
    last: Option<(f64, f64, f64)>,
    /// Whether the last step did not converge.
    adrift: bool,
    written: Vec<String>,
    /// Linear solves of U, pressure and fluidity.
    solves: [SolveCount; 3],
    /// Whether the last step solved momentum and continuity together.
    coupled: bool,
    /// Where friction is used up, if the last step did not converge.
    beyond: Option<Beyond>,
    /// Where the law was ill-posed in the last step.
    posedness: Posedness,
}

impl Tally {
    pub(crate) fn new(case: &Case) -> Tally {
        Tally { began_at: case.start.time, ..Tally::default() }
    }

    pub(crate) fn note(&mut self, event: &StepEvent) {
        let r = &event.report;
        self.steps += 1;
        self.coupled = r.coupled;
        self.unconverged += usize::from(!r.converged);
        self.adrift = !r.converged;
        self.beyond = r.rheology.beyond.filter(|_| !r.converged);
        let g = &r.rheology;
        let fluidity = (g.solves > 0).then_some(g.residual);
        self.steady = r.steady.then_some((r.residuals, fluidity));
        self.posedness = r.rheology.posedness;
        self.solves[0] += r.solves[0];
        self.solves[1] += r.solves[1];
        self.solves[2] += SolveCount { all: g.solves, unconverged: g.unconverged };
        // A short step, fitted to a write time, says little about a rate of change.
        if self.last.is_none_or(|(_, dt, _)| r.dt >= 0.5 * dt) {
            self.last = Some((r.time, r.dt, r.change));
        }
        if let Some(name) = &event.wrote {
            self.written(name.clone());
        }
    }

    /// A time directory holds results of this run.
    pub(crate) fn written(&mut self, name: String) {
        if self.steps > 0 && self.written.last() != Some(&name) {
            self.written.push(name);
        }
    }

    pub(crate) fn summary(&self, session: &mut Session, case: &Case, time: f64, wall: f64) {
        if self.steps == 0 {
            return;
        }
        let mut line = format!("t {} s after {}", rounded(time, 6), count(self.steps, "step"));
        line += &format!(", {} wall time", duration(wall));
        line += &format!(" ({} ms a step)", number(1e3 * wall / self.steps as f64));
        session.out.say(&line);
        if let Some(line) = self.steadiness() {
            session.out.say(&line);
        }
        if self.unconverged > 0 {
            session.out.say(&format!(
                "warning: {} of {} did not meet residualControl within nOuterCorrectors",
                self.unconverged,
                count(self.steps, "step"),
            ));
        }
        for line in self.unsolved(&case.config.solution, case.config.pressure()) {
            session.out.say(&line);
        }
        if let Some(b) = &self.beyond {
            session.out.say(&format!(
                "warning: friction is used up in {}: mu = {} (I = {}) in cell {} at {}, and mu2 = {} \
                 is all that grains have, so that no steady flow exists there",
                count(b.cells, "cell"),
                rounded(b.mu, 4),
                number(b.inertial),
                b.cell,
                at(b.place),
                b.mu_2,
            ));
        }
        if let Some(line) = ill_posed(&self.posedness) {
            session.out.say(&line);
        }
    }

    /// A line for each field whose linear systems were not all solved.
    fn unsolved(&self, solution: &Solution, pressure: &str) -> Vec<String> {
        let fields =
            [("U", &solution.u), (pressure, &solution.p), ("fluidity", &solution.fluidity)];
        let mut lines = Vec::new();
        for ((name, linear), solves) in fields.into_iter().zip(&self.solves) {
            if solves.unconverged == 0 {
                continue;
            }
            if self.coupled && name != "fluidity" {
                // No word of these unless they may have done harm: the residuals of the steps judge.
                if self.unconverged > 0 && 20 * solves.unconverged > solves.all {
                    lines.push(format!(
                        "warning: {name}: {} of {} inside outer iterations fell short; another \
                         solver or preconditioner may do better (maxIter has no say there)",
                        solves.unconverged,
                        count(solves.all, "solve"),
                    ));
                }
                continue;
            }
            // Multigrid solves what it is made for, and momentum and fluidity are not always.
            let other = if linear.spec.solver != "GAMG" && name == pressure {
                " or use GAMG"
            } else {
                " or tolerance"
            };
            lines.push(format!(
                "warning: {name}: {} of {} ended unconverged; raise maxIter{other}",
                solves.unconverged,
                count(solves.all, "solve"),
            ));
        }
        lines
    }

    /// How far the flow would still move if it went on at its last rate for as long as this run.
    fn steadiness(&self) -> Option<String> {
        let (time, dt, change) = self.last?;
        if let Some((r, fluidity)) = self.steady {
            let fluidity = fluidity.map_or(String::new(), |g| {
                format!("the fluidity's equation by {} of its terms, ", residual(g))
            });
            return Some(format!(
                "steady state: forces are out of balance by {} of their size, the flux by {}, {fluidity}the \
                 viscosity would change by {}",
                residual(r.u),
                residual(r.p),
                residual(r.viscosity),
            ));
        }
        if self.adrift {
            // What stands still need not be a solution.
            return Some(
                "the last step did not converge: nothing is said of a steady state".into(),
            );
        }
        let span = time - self.began_at;
        let drift = change / dt * span;
        let (word, rate) = match drift {
            d if d <= STEADY => ("steady", number(d)),
            d => ("not steady", number(d)),
        };
        Some(format!(
            "{word}: in another {} s at its last rate U would change by {rate} of its maximum",
            rounded(span, 3)
        ))
    }

    pub(crate) fn say_where(&self, session: &mut Session, root: &Path) {
        let (Some(first), Some(last)) = (self.written.first(), self.written.last()) else { return };
        session.out.say(&match self.written.len() {
            1 => format!("results  {}", place(root, last)),
            n => format!("results  {} to {last} ({})", place(root, first), count(n, "time")),
        });
        if root.join("postProcessing").is_dir() {
            session.out.say(&format!("         {}", place(root, "postProcessing")));
        }
    }
}

/// What to say of grains that are pulled apart.
pub(crate) fn pulled_apart(t: &Tensile, time: f64) -> String {
    format!(
        "warning: the pressure is not positive in {} at t {} s, the least {} Pa in cell {} at {}: \
         grains fall apart there and carry no stress\n  = help: likely the pressure given at a \
         boundary or by pRefValue is too low, or walls or outlets pull the material; results in \
         these cells mean nothing",
        count(t.cells, "cell"),
        rounded(time, 6),
        number(t.pressure),
        t.cell,
        at(t.place),
    )
}

/// What to say of a step that failed and was taken again.
pub(crate) fn taken_again(s: &Shortened) -> String {
    format!("warning: a step of {} s failed and was taken again, shorter: {}", number(s.dt), s.why)
}

/// What to say where mu(I) alone lets disturbances grow without bounds.
fn ill_posed(p: &Posedness) -> Option<String> {
    let share = 100.0 * p.ill_posed as f64 / p.yielded.max(1) as f64;
    (p.ill_posed > 0).then(|| {
        format!(
            "warning: mu(I) is ill-posed in {} of {} that yield ({} %) at the end: disturbances grow \
             there, the faster the finer the mesh\n  = help: `transportModel muIRegularised` is well \
             posed",
            p.ill_posed,
            count(p.yielded, "cell"),
            rounded(share, 3),
        )
    })
}

fn at(place: [f64; 3]) -> String {
    format!("({} {} {})", number(place[0]), number(place[1]), number(place[2]))
}

/// Greatest drift that counts as steady.
const STEADY: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ill_posed_cells_are_told_if_there_are_any() {
        let says = |yielded, ill_posed| ill_posed_line(yielded, ill_posed);
        assert_eq!(says(40, 0), None);
        assert_eq!(says(0, 0), None);
        let line = says(40, 10).unwrap();
        assert!(line.contains("in 10 of 40 cells that yield (25 %)"), "{line}");
    }

    fn ill_posed_line(yielded: usize, ill_posed: usize) -> Option<String> {
        super::ill_posed(&Posedness { yielded, ill_posed })
    }

    #[test]
    fn steady_is_a_matter_of_rate_not_of_the_length_of_a_step() {
        let tally = |dt: f64, change: f64| Tally {
            steps: 1,
            last: Some((10.0, dt, change)),
            ..Tally::default()
        };
        let says = |t: Tally| t.steadiness().unwrap();
        assert!(says(tally(1.0, 1e-6)).starts_with("steady: in another 10 s"));
        assert!(says(tally(1e-4, 1e-6)).starts_with("not steady"), "small steps change little");
        let adrift = Tally { adrift: true, ..tally(1.0, 1e-6) };
        assert!(!says(adrift).starts_with("steady"), "what did not converge is not steady");
    }
}
