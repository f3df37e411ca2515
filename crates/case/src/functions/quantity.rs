//! What functions may look at, by name.

use super::Reading;
use super::field::{Rank, Unit};
use granflow_base::Dims;
use granflow_dict::{Diag, Reader, Sink, Span, nearest};

/// A field that functions may look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Velocity, m/s.
    U,
    /// Pressure, in the units of the case's files.
    P,
    /// Pressure without its hydrostatic part, in the units of the case's files.
    PRgh,
    /// Volume fraction of the first phase, by its name in files (`alpha.water`).
    Alpha,
    /// Density, kg/m3.
    Rho,
    /// Fluidity, 1/s.
    Fluidity,
    /// `sqrt(2 D:D)`, 1/s.
    StrainRate,
    /// Dynamic viscosity, Pa s.
    Viscosity,
    /// Shear stress over pressure.
    StressRatio,
    /// Inertial number.
    InertialNumber,
    /// Field `slot` of those that the function number `function` makes.
    Made {
        /// Which function.
        function: usize,
        /// Which of its fields.
        slot: usize,
        /// What it holds.
        rank: Rank,
    },
}

impl Quantity {
    /// Every quantity of the flow itself with its name.
    pub const ALL: &[(&str, Quantity)] = &[
        ("U", Quantity::U),
        ("p", Quantity::P),
        ("p_rgh", Quantity::PRgh),
        ("alpha", Quantity::Alpha),
        ("rho", Quantity::Rho),
        ("fluidity", Quantity::Fluidity),
        ("strainRate", Quantity::StrainRate),
        ("viscosity", Quantity::Viscosity),
        ("stressRatio", Quantity::StressRatio),
        ("inertialNumber", Quantity::InertialNumber),
    ];
    /// What it holds.
    pub fn rank(self) -> Rank {
        match self {
            Quantity::U => Rank::Vector,
            Quantity::Made { rank, .. } => rank,
            _ => Rank::Scalar,
        }
    }
    /// Its number of components.
    pub fn n(self) -> usize {
        self.rank().n()
    }
    /// Its dimensions, but for those of what functions make.
    fn unit(self) -> Unit {
        match self {
            Quantity::U => Unit::of(Dims::VELOCITY),
            Quantity::P | Quantity::PRgh => Unit::PRESSURE,
            Quantity::Rho => Unit::of(Dims::DENSITY),
            Quantity::Fluidity | Quantity::StrainRate => Unit::of(Dims::RATE),
            Quantity::Viscosity => Unit::of(Dims::VISCOSITY),
            _ => Unit::of(Dims::NONE),
        }
    }
    /// Whether boundary faces have values of their own.
    fn on_faces(self) -> bool {
        matches!(self, Quantity::U | Quantity::P | Quantity::PRgh | Quantity::Alpha)
    }
    /// Whether it follows from the state by a computation of its own.
    pub fn derived(self) -> bool {
        matches!(
            self,
            Quantity::StrainRate
                | Quantity::Viscosity
                | Quantity::StressRatio
                | Quantity::InertialNumber
        )
    }
}

/// A field under the name that the dictionary gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// The name, which files and columns have.
    pub name: String,
    /// The field.
    pub quantity: Quantity,
    /// Its dimensions.
    pub unit: Unit,
    /// Whether boundary faces have values of their own.
    pub on_faces: bool,
}

impl Named {
    /// The field called `name`, if there is one.
    pub(super) fn find(name: &str, reading: &Reading<'_>) -> Option<Named> {
        if let Some(made) = reading.made.iter().rev().find(|m| m.info.name == name) {
            let quantity =
                Quantity::Made { function: made.function, slot: made.slot, rank: made.info.rank };
            let (unit, on_faces) = (made.info.unit, made.info.on_faces);
            return Some(Named { name: name.into(), quantity, unit, on_faces });
        }
        let word = if name.starts_with("alpha.") { "alpha" } else { name };
        let quantity = Quantity::ALL.iter().find(|q| q.0 == word)?.1;
        let (unit, on_faces) = (quantity.unit(), quantity.on_faces());
        Some(Named { name: name.into(), quantity, unit, on_faces })
    }

    /// The field called `name`, which stands at `span`; a mistake goes to the sink.
    pub(super) fn read(r: &Reader<'_>, span: &Span, name: &str, reading: &Reading<'_>) -> Named {
        if let Some(found) = Named::find(name, reading) {
            return found;
        }
        if !name.is_empty() {
            let names: Vec<&str> = Quantity::ALL
                .iter()
                .map(|q| q.0)
                .chain(reading.made.iter().map(|m| m.info.name.as_str()))
                .collect();
            let near = nearest(name, names.iter().copied());
            let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
            let help = format!(
                "{near}known fields are {}, and what functions before this one make",
                names.join(", ")
            );
            r.error_at(span, format!("unknown field `{name}`"), "not known", Some(&help));
        }
        Named { name: name.into(), quantity: Quantity::U, unit: Quantity::U.unit(), on_faces: true }
    }

    /// Names of its columns: `U_x U_y U_z` or the name alone.
    pub fn columns(&self) -> Vec<String> {
        let suffixes = self.quantity.rank().suffixes();
        suffixes.iter().map(|s| format!("{}{s}", self.name)).collect()
    }
}

/// Fields a function was asked for.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    /// The fields.
    pub(crate) list: Vec<Named>,
    /// Where they were written.
    pub(crate) span: Span,
}

impl Wanted {
    /// Reads a list of names under `key`; mistakes go to the sink.
    pub(crate) fn read(r: &Reader<'_>, key: &str, reading: &Reading<'_>) -> Wanted {
        let told = r.sink().n_errors();
        let words = r.words(key);
        let span = r.value_span(key);
        if words.is_empty() && r.sink().n_errors() == told {
            let help = Some("name fields: `(U p)`");
            r.error_at_key(key, format!("`{key}` names no field"), "an empty list", help);
        }
        let list = words.into_iter().map(|w| Named::read(r, &span, w, reading)).collect();
        Wanted { list, span }
    }
    /// Reads the one name under `key`.
    pub(crate) fn one(r: &Reader<'_>, key: &str, reading: &Reading<'_>) -> Wanted {
        let span = r.value_span(key);
        let list = vec![Named::read(r, &span, r.string(key), reading)];
        Wanted { list, span }
    }
    /// Reads a `field` that can only be the velocity.
    pub(crate) fn velocity(r: &Reader<'_>) -> Wanted {
        for key in ["U", "field"] {
            if r.maybe_string(key).is_some_and(|w| w != "U") {
                let help = "`grad`, `div` and `mag` take any field";
                r.error_at_key(key, "this is made of the velocity", "write `U`", Some(help));
            }
        }
        Wanted { list: Vec::new(), span: Span::none() }
    }
    /// Complains about fields that this case does not have.
    pub(crate) fn check(&self, config: &crate::CaseConfig, sink: &Sink) {
        for q in &self.list {
            let why = match q.quantity {
                Quantity::PRgh if config.pressure() == "p" => "the case has no gravity: use `p`",
                Quantity::Alpha if config.transport.second.is_none() => "it has one phase only",
                Quantity::Fluidity if !config.transport.has_fluidity => {
                    "only nonlocal rheologies have a fluidity"
                }
                Quantity::StressRatio | Quantity::InertialNumber
                    if config.transport.grains.is_none() =>
                {
                    "only granular rheologies have it"
                }
                _ => continue,
            };
            let message = format!("the case has no field `{}`", q.name);
            sink.push(Diag::error(&self.span, message).label(why));
        }
    }
    /// Whether one of them must be computed.
    pub(crate) fn derived(&self) -> bool {
        self.list.iter().any(|q| q.quantity.derived())
    }
    /// The functions that make some of them.
    pub(crate) fn uses(&self) -> Vec<usize> {
        let of = |q: &Named| match q.quantity {
            Quantity::Made { function, .. } => Some(function),
            _ => None,
        };
        self.list.iter().filter_map(of).collect()
    }
}
