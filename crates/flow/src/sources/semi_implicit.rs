//! A given force per volume, perhaps less a drag (`vectorSemiImplicitSource`).

use super::{Entry, Given, Seen, Source, Zone, three};
use granflow_base::{Value, Vec3, scale};

/// `force - drag U` in some cells, for some time.
#[derive(Clone, Debug)]
pub struct SemiImplicit {
    /// The name of the entry.
    pub name: String,
    /// Where.
    pub zone: Zone,
    /// Force per volume, N/m3.
    pub force: Vec3,
    /// Drag per volume and velocity, kg/(m3 s).
    pub drag: f64,
    /// First and last time, s.
    pub window: [f64; 2],
}

impl Source for SemiImplicit {
    fn name(&self) -> &str {
        &self.name
    }
    fn kind(&self) -> &'static str {
        ENTRY.names[0]
    }
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn says(&self, number: &dyn Fn(f64) -> String) -> String {
        let drag = match self.drag {
            0.0 => String::new(),
            drag => format!(" less {} kg/(m3 s) times U", number(drag)),
        };
        format!("a force of {} N/m3{drag}", three(self.force, number))
    }
    fn add(&self, seen: &Seen<'_>, n: usize, body: &mut [Vec3], sink: &mut [f64]) {
        if !(self.window[0]..=self.window[1]).contains(&seen.time) {
            return;
        }
        self.zone.each(n, |c| {
            body[c] = body[c].plus(self.force);
            sink[c] += self.drag;
        });
    }
    fn stays(&self, from: f64, to: f64) -> bool {
        let [first, last] = self.window;
        first <= from && last >= to || last < from || first > to
    }
    fn boxed(&self) -> Box<dyn Source> {
        Box::new(self.clone())
    }
}

pub(super) const ENTRY: Entry = Entry {
    names: &["vectorSemiImplicitSource", "semiImplicitSource"],
    summary: "a given force and a drag, in all cells or in a zone, perhaps for a time",
    formula: "f = S + k U, k <= 0, of `U (S k);` in injectionRateSuSp; over the volume of the zone \
              with volumeMode absolute",
    reference: "OpenFOAM user guide, fvOptions",
    read,
};

fn read(of: &Given<'_, '_>) -> Vec<Box<dyn Source>> {
    let r = of.r;
    let window = of.window();
    let absolute = r.one_of("volumeMode", &[("specific", false), ("absolute", true)]);
    let per = of.rho / if absolute { of.volume() } else { 1.0 };
    let mut sources: Vec<Box<dyn Source>> = Vec::new();
    let Some(rates) = r.sub("injectionRateSuSp") else { return sources };
    if rates.keys().is_empty() {
        let help = Some("write `U ((x y z) 0);` in it");
        r.error_at_key("injectionRateSuSp", "no force is given", "empty", help);
    }
    for key in rates.keys() {
        let Some(mut t) = rates.tokens(key) else { continue };
        if key != "U" {
            let help = Some("forces act on `U`");
            rates.error_at_key(key, format!("there is no equation of `{key}`"), "not known", help);
            continue;
        }
        let Some(mut pair) = t.list("force and drag, `((x y z) 0)`") else { continue };
        let force = scale(pair.vector("the force"), per);
        // OpenFOAM's rate of the implicit part is that of growth.
        let drag = -pair.number("the rate of the implicit part") * per;
        pair.finish();
        if drag < 0.0 {
            let help = Some("a drag is negative: `((x y z) -5)`");
            rates.error_at_key(key, "a force that grows with the velocity", "positive", help);
        }
        let (name, zone) = (of.name.to_owned(), of.zone.clone());
        sources.push(Box::new(SemiImplicit { name, zone, force, drag, window }));
    }
    sources
}
