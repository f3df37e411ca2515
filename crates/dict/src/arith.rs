//! Arithmetic of `#calc`, `#eval` and `${{ }}`: numbers, and vectors as OpenFOAM's `#eval` has them.
//!
//! Among vectors `&` binds as a product does and `^`, the cross product, looser than a sum: foamDictionary of
//! v1912 makes `(3 1 0) ^ (0 1 0)` of `vector(1,1,0) + 2*vector(1,0,0) ^ vector(0,1,0)`. Among numbers `^` is
//! the power.

/// A number or a vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Quantity {
    Number(f64),
    Vector([f64; 3]),
}
use Quantity::{Number, Vector};

/// A value and what to say about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Evaluated {
    pub(crate) value: Quantity,
    /// A quotient of whole numbers was not whole: C++ (and so OpenFOAM's `#calc`) would cut it.
    pub(crate) cut_in_cpp: bool,
}

/// What is wrong with an expression, at a byte offset of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ArithError {
    pub(crate) at: usize,
    pub(crate) message: String,
}

/// Looks up the number a `$name` stands for, or says why it has none.
pub(crate) type Lookup<'l> = &'l dyn Fn(&str) -> Result<f64, String>;

/// Evaluates `text`.
pub(crate) fn eval(text: &str, lookup: Lookup<'_>) -> Result<Evaluated, ArithError> {
    let mut p = Parser { b: text.as_bytes(), text, at: 0, lookup, cut: false, depth: 0 };
    let value = p.ternary()?.0;
    p.space();
    if p.at < p.b.len() && p.b[p.at] != b';' {
        return p.err(format!("`{}` is not expected here", p.rest()));
    }
    let finite = match value {
        Number(x) => x.is_finite(),
        Vector(v) => v.iter().all(|x| x.is_finite()),
    };
    if !finite {
        return Err(ArithError { at: 0, message: "the result is not a finite number".into() });
    }
    Ok(Evaluated { value, cut_in_cpp: p.cut })
}

/// A value and whether C++ would hold it as an integer.
type Num = (Quantity, bool);

struct Parser<'t> {
    b: &'t [u8],
    text: &'t str,
    at: usize,
    lookup: Lookup<'t>,
    cut: bool,
    depth: usize,
}

fn truth(b: bool) -> Num {
    (Number(f64::from(u8::from(b))), true)
}

/// Component by component.
fn both(a: [f64; 3], b: [f64; 3], f: impl Fn(f64, f64) -> f64) -> [f64; 3] {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}
fn inner(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Parser<'_> {
    fn err<T>(&self, message: impl Into<String>) -> Result<T, ArithError> {
        Err(ArithError { at: self.at, message: message.into() })
    }
    fn rest(&self) -> String {
        self.text.get(self.at..).unwrap_or("").chars().take(12).collect()
    }
    fn space(&mut self) {
        while self.b.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }
    /// Takes the first of `ops` that stands here.
    fn take(&mut self, ops: &[&'static str]) -> Option<&'static str> {
        self.space();
        let op = ops.iter().copied().find(|op| self.b[self.at..].starts_with(op.as_bytes()))?;
        self.at += op.len();
        Some(op)
    }
    /// The number that is needed here.
    fn number(&self, of: Num) -> Result<f64, ArithError> {
        match of.0 {
            Number(x) => Ok(x),
            Vector(_) => self.err("a number is needed here, and this is a vector"),
        }
    }
    fn ternary(&mut self) -> Result<Num, ArithError> {
        self.depth += 1;
        if self.depth > 100 {
            return self.err("this expression is nested too deeply");
        }
        let test = self.or()?;
        let out = if self.take(&["?"]).is_some() {
            let yes = self.ternary()?;
            if self.take(&[":"]).is_none() {
                return self.err("`:` is missing");
            }
            let no = self.ternary()?;
            if self.number(test)? != 0.0 { yes } else { no }
        } else {
            test
        };
        self.depth -= 1;
        Ok(out)
    }
    fn or(&mut self) -> Result<Num, ArithError> {
        let mut x = self.and()?;
        while self.take(&["||"]).is_some() {
            let y = self.and()?;
            x = truth(self.number(x)? != 0.0 || self.number(y)? != 0.0);
        }
        Ok(x)
    }
    fn and(&mut self) -> Result<Num, ArithError> {
        let mut x = self.comparison()?;
        while self.take(&["&&"]).is_some() {
            let y = self.comparison()?;
            x = truth(self.number(x)? != 0.0 && self.number(y)? != 0.0);
        }
        Ok(x)
    }
    fn comparison(&mut self) -> Result<Num, ArithError> {
        let mut x = self.crossed()?;
        while let Some(op) = self.take(&["==", "!=", "<=", ">=", "<", ">"]) {
            let y = self.crossed()?;
            x = truth(match op {
                "==" => x.0 == y.0,
                "!=" => x.0 != y.0,
                _ => {
                    let (x, y) = (self.number(x)?, self.number(y)?);
                    match op {
                        "<=" => x <= y,
                        ">=" => x >= y,
                        "<" => x < y,
                        _ => x > y,
                    }
                }
            });
        }
        Ok(x)
    }
    /// Cross products.
    fn crossed(&mut self) -> Result<Num, ArithError> {
        let mut x = self.sum()?;
        while let Vector(a) = x.0 {
            if self.take(&["^"]).is_none() {
                break;
            }
            let Vector(b) = self.sum()?.0 else {
                return self.err("behind `^` and a vector a vector is needed");
            };
            let of = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            x = (Vector([of(1, 2), of(2, 0), of(0, 1)]), false);
        }
        Ok(x)
    }
    fn sum(&mut self) -> Result<Num, ArithError> {
        let mut x = self.product()?;
        while let Some(op) = self.take(&["+", "-"]) {
            let y = self.product()?;
            let f = |x: f64, y: f64| if op == "+" { x + y } else { x - y };
            x = match (x.0, y.0) {
                (Number(a), Number(b)) => (Number(f(a, b)), x.1 && y.1),
                (Vector(a), Vector(b)) => (Vector(both(a, b, f)), false),
                _ => return self.err(format!("a vector `{op}` a number")),
            };
        }
        Ok(x)
    }
    fn product(&mut self) -> Result<Num, ArithError> {
        let mut x = self.unary()?;
        loop {
            let Some(op) = self.take(&["*", "/", "%", "&&", "&"]) else { return Ok(x) };
            if op == "&&" {
                self.at -= op.len();
                return Ok(x);
            }
            let y = self.unary()?;
            let int = x.1 && y.1;
            x = match (x.0, op, y.0) {
                (Number(a), "*", Number(b)) => (Number(a * b), int),
                (Number(a), "/", Number(b)) => {
                    let q = a / b;
                    self.cut |= int && q != q.trunc();
                    (Number(q), int && q == q.trunc())
                }
                (Number(a), "%", Number(b)) => (Number(a % b), int),
                (Number(a), "*", Vector(v)) | (Vector(v), "*", Number(a)) => {
                    (Vector(v.map(|x| a * x)), false)
                }
                (Vector(v), "/", Number(a)) => (Vector(v.map(|x| x / a)), false),
                (Vector(a), "&", Vector(b)) => (Number(inner(a, b)), false),
                (Vector(_), "*", Vector(_)) => {
                    return self
                        .err("`*` of two vectors is a tensor, which is not done: `&` or `^`");
                }
                _ => return self.err(format!("`{op}` is not for these")),
            };
        }
    }
    fn unary(&mut self) -> Result<Num, ArithError> {
        // A loop, not a recursion: `------1` must not exhaust the stack.
        let (mut minus, mut not) = (false, 0u8);
        while let Some(op) = self.take(&["-", "+", "!"]) {
            match op {
                "-" => minus = !minus,
                "!" => not = if not == 1 { 2 } else { 1 },
                _ => {}
            }
        }
        let mut x = self.power()?;
        if not > 0 {
            x = truth((self.number(x)? != 0.0) == (not == 2));
        }
        let negative = match x.0 {
            Number(a) => Number(-a),
            Vector(v) => Vector(v.map(|x| -x)),
        };
        Ok(if minus { (negative, x.1) } else { x })
    }
    fn power(&mut self) -> Result<Num, ArithError> {
        let mut x = self.primary()?;
        while let Vector(v) = x.0 {
            let Some(part) = self.take(&[".x()", ".y()", ".z()"]) else { return Ok(x) };
            x = (Number(v[usize::from(part.as_bytes()[1] - b'x')]), false);
        }
        if self.take(&["^"]).is_none() {
            return Ok(x);
        }
        self.depth += 1;
        if self.depth > 100 {
            return self.err("this expression is nested too deeply");
        }
        let y = self.unary()?;
        self.depth -= 1;
        Ok((Number(self.number(x)?.powf(self.number(y)?)), false))
    }
    fn primary(&mut self) -> Result<Num, ArithError> {
        self.space();
        match self.b.get(self.at) {
            Some(b'(') => {
                self.at += 1;
                let x = self.ternary()?;
                self.close()?;
                Ok(x)
            }
            Some(b'$') => self.variable(),
            Some(c) if c.is_ascii_digit() || *c == b'.' => self.literal(),
            Some(c) if c.is_ascii_alphabetic() || *c == b'_' => self.named(),
            Some(_) => self.err(format!("`{}`: a number is needed here", self.rest())),
            None => self.err("the expression ends where a number is needed"),
        }
    }
    fn close(&mut self) -> Result<(), ArithError> {
        if self.take(&[")"]).is_none() {
            return self.err("`)` is missing");
        }
        Ok(())
    }
    fn run(&self, from: usize, ok: impl Fn(u8) -> bool) -> usize {
        self.b[from..].iter().position(|&c| !ok(c)).map_or(self.b.len(), |n| from + n)
    }
    fn literal(&mut self) -> Result<Num, ArithError> {
        let mut end = self.run(self.at, |c| c.is_ascii_digit() || c == b'.');
        if matches!(self.b.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(self.b.get(end + 1), Some(b'+' | b'-')));
            let digits = self.run((end + 1 + sign).min(self.b.len()), |c| c.is_ascii_digit());
            if digits > end + 1 + sign {
                end = digits;
            }
        }
        let text = &self.text[self.at..end];
        let Ok(x) = text.parse() else { return self.err(format!("`{text}` is not a number")) };
        self.at = end;
        Ok((Number(x), text.bytes().all(|c| c.is_ascii_digit())))
    }
    fn variable(&mut self) -> Result<Num, ArithError> {
        let braced = self.b.get(self.at + 1) == Some(&b'{');
        let from = self.at + 1 + usize::from(braced);
        let end = if braced {
            self.run(from, |c| c != b'}')
        } else {
            self.run(from, |c| c.is_ascii_alphanumeric() || matches!(c, b'_' | b'.' | b':'))
        };
        let name = self.text.get(from..end).unwrap_or("");
        match (self.lookup)(name) {
            Ok(x) => {
                self.at = (end + usize::from(braced)).min(self.b.len());
                Ok((Number(x), x == x.trunc()))
            }
            Err(why) => self.err(why),
        }
    }
    fn named(&mut self) -> Result<Num, ArithError> {
        let from = self.at;
        let end = self.run(from, |c| c.is_ascii_alphanumeric() || c == b'_' || c == b':');
        let full = self.text[from..end].trim_end_matches(':');
        let end = from + full.len();
        let name = full.rsplit("::").next().unwrap_or(full);
        self.at = end;
        let mut args = Vec::new();
        let called = self.take(&["("]).is_some();
        if called && self.take(&[")"]).is_none() {
            loop {
                args.push(self.ternary()?);
                if self.take(&[","]).is_none() {
                    break;
                }
            }
            self.close()?;
        }
        if let Some(out) = of_vectors(name, &args) {
            return Ok((out, false));
        }
        let x = args.iter().map(|a| self.number(*a)).collect::<Result<Vec<f64>, _>>()?;
        if let Some(v) = function(name, &x) {
            return Ok((Number(v), false));
        }
        let int = args.iter().all(|a| a.1);
        match (name, x.as_slice()) {
            ("min", [a, b]) => Ok((Number(a.min(*b)), int)),
            ("max", [a, b]) => Ok((Number(a.max(*b)), int)),
            ("abs" | "mag", [a]) => Ok((Number(a.abs()), int)),
            ("bool", [a]) => Ok(truth(*a != 0.0)),
            ("int" | "label", [a]) => Ok((Number(a.trunc()), true)),
            ("true", []) => Ok(truth(true)),
            ("false", []) => Ok(truth(false)),
            _ => {
                self.at = from;
                let near = crate::nearest(name, NAMES.iter().copied());
                let hint = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
                let kind = if called { "function" } else { "name" };
                self.err(format!("unknown {kind} `{name}` with {} arguments{hint}", x.len()))
            }
        }
    }
}

const NAMES: &[&str] = &[
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log",
    "log10", "sqrt", "cbrt", "pow", "sqr", "pow3", "pow4", "abs", "mag", "fabs", "sign", "floor",
    "ceil", "round", "min", "max", "mod", "hypot", "degToRad", "radToDeg", "pi", "twoPi", "scalar",
    "label", "int", "vector", "magSqr",
];

/// Functions that make vectors or take them.
fn of_vectors(name: &str, args: &[Num]) -> Option<Quantity> {
    let args: Vec<Quantity> = args.iter().map(|a| a.0).collect();
    Some(match (name, args.as_slice()) {
        ("vector", [Number(x), Number(y), Number(z)]) => Vector([*x, *y, *z]),
        ("mag", [Vector(v)]) => Number(inner(*v, *v).sqrt()),
        ("magSqr", [Vector(v)]) => Number(inner(*v, *v)),
        ("magSqr", [Number(x)]) => Number(x * x),
        ("min", [Vector(a), Vector(b)]) => Vector(both(*a, *b, f64::min)),
        ("max", [Vector(a), Vector(b)]) => Vector(both(*a, *b, f64::max)),
        _ => return None,
    })
}

fn function(name: &str, x: &[f64]) -> Option<f64> {
    use std::f64::consts::{E, FRAC_PI_2, PI, TAU};
    Some(match (name, x) {
        ("pi" | "M_PI", []) => PI,
        ("twoPi", []) => TAU,
        ("piByTwo", []) => FRAC_PI_2,
        ("e", []) => E,
        ("sin", [a]) => a.sin(),
        ("cos", [a]) => a.cos(),
        ("tan", [a]) => a.tan(),
        ("asin", [a]) => a.asin(),
        ("acos", [a]) => a.acos(),
        ("atan", [a]) => a.atan(),
        ("atan2", [a, b]) => a.atan2(*b),
        ("sinh", [a]) => a.sinh(),
        ("cosh", [a]) => a.cosh(),
        ("tanh", [a]) => a.tanh(),
        ("exp", [a]) => a.exp(),
        ("log", [a]) => a.ln(),
        ("log10", [a]) => a.log10(),
        ("sqrt", [a]) => a.sqrt(),
        ("cbrt", [a]) => a.cbrt(),
        ("pow", [a, b]) => a.powf(*b),
        ("sqr", [a]) => a * a,
        ("pow3", [a]) => a * a * a,
        ("pow4", [a]) => (a * a) * (a * a),
        ("fabs", [a]) => a.abs(),
        ("sign", [a]) if *a < 0.0 => -1.0,
        ("sign", [_]) => 1.0,
        ("floor", [a]) => a.floor(),
        ("ceil", [a]) => a.ceil(),
        ("round", [a]) => a.round(),
        ("mod" | "fmod", [a, b]) => a % b,
        ("hypot", [a, b]) => a.hypot(*b),
        ("degToRad", [a]) => a.to_radians(),
        ("radToDeg", [a]) => a.to_degrees(),
        ("degToRad", []) => 1f64.to_radians(),
        ("radToDeg", []) => 1f64.to_degrees(),
        ("scalar" | "double", [a]) => *a,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Quantity {
        eval(text, &|n| if n == "x" { Ok(3.0) } else { Err(format!("no {n}")) }).unwrap().value
    }
    fn value(text: &str) -> f64 {
        match of(text) {
            Number(x) => x,
            Vector(v) => panic!("{v:?}"),
        }
    }

    /// As foamDictionary of v1912 prints them.
    #[test]
    fn vectors_as_openfoam_has_them() {
        for (text, v) in [
            ("vector(1,2,3) * 2", [2.0, 4.0, 6.0]),
            ("2 * vector(1,2,3)", [2.0, 4.0, 6.0]),
            ("vector(1,2,3) / 2", [0.5, 1.0, 1.5]),
            ("vector(1,2,3) + vector(1,1,1)", [2.0, 3.0, 4.0]),
            ("-vector(1,2,3)", [-1.0, -2.0, -3.0]),
            ("vector(1,0,0) ^ vector(0,1,0)", [0.0, 0.0, 1.0]),
            ("vector(1,1,0)+2*vector(1,0,0)^vector(0,1,0)", [0.0, 0.0, 3.0]),
            ("vector(sqrt(4), $x, 2*3)", [2.0, 3.0, 6.0]),
            ("1 > 0 ? vector(1,0,0) : vector(0,1,0)", [1.0, 0.0, 0.0]),
            ("min(vector(1,5,3), vector(4,2,6))", [1.0, 2.0, 3.0]),
        ] {
            assert_eq!(of(text), Vector(v), "{text}");
        }
        for (text, x) in [
            ("mag(vector(3,4,0))", 5.0),
            ("magSqr(vector(3,4,0))", 25.0),
            ("vector(1,2,3) & vector(4,5,6)", 32.0),
            ("vector(1,2,3) & vector(1,1,1) * 2", 12.0),
            ("1 + vector(1,2,3) & vector(1,1,1)", 7.0),
            ("vector(1,2,3).x()", 1.0),
            ("vector(1,2,3).z() ^ 2", 9.0),
            ("vector(1,2,3) == vector(1,2,3)", 1.0),
            ("1 && vector(1,2,3).y() > 1", 1.0),
        ] {
            assert_eq!(value(text), x, "{text}");
        }
        let wrong = |t: &str| eval(t, &|_| Ok(1.0)).unwrap_err().message;
        assert!(wrong("vector(1,2,3) - 1").contains("a vector `-` a number"));
        assert!(wrong("2 / vector(1,2,3)").contains("`/` is not for these"));
        assert!(wrong("vector(1,2,3) * vector(1,1,1)").contains("tensor"));
        assert!(wrong("vector(1,2,3) ^ 2").contains("a vector is needed"));
        assert!(wrong("vector(1,0,0)^vector(0,1,0)&vector(0,0,1)").contains("a vector is needed"));
        assert!(wrong("sqr(vector(1,2,3))").contains("a number is needed"));
        assert!(wrong("vector(1,2)").contains("`vector` with 2 arguments"));
    }

    #[test]
    fn precedence_is_that_of_mathematics() {
        assert_eq!(value("1 + 2*3 - 8/4"), 5.0);
        assert_eq!(value("-2^2"), -4.0);
        assert_eq!(value("2^3^2"), 512.0);
        assert_eq!(value("2^-1"), 0.5);
        assert_eq!(value("(1+2)*$x"), 9.0);
        assert_eq!(value("${x} > 2 && !0 ? 7 : 8"), 7.0);
        assert_eq!(value("1.5e3 % 7"), 1500.0 % 7.0);
    }

    #[test]
    fn functions_and_names_with_scopes() {
        assert_eq!(value("Foam::sqrt(16.) + std::pow(2, 3)"), 12.0);
        assert_eq!(value("degToRad(180) - constant::mathematical::pi"), 0.0);
        assert_eq!(value("max(1, min($x, 2))"), 2.0);
    }

    #[test]
    fn mistakes_have_a_place() {
        let e = |t: &str| eval(t, &|n| Err(format!("unknown `${n}`"))).unwrap_err();
        assert_eq!(
            e("1 + "),
            ArithError { at: 4, message: "the expression ends where a number is needed".into() }
        );
        assert_eq!(e("2*sqr(1, 2)").at, 2);
        assert!(e("sqt(2)").message.contains("did you mean `sqrt`?"));
        assert_eq!(e("(1").message, "`)` is missing");
        assert_eq!(e("1/0").message, "the result is not a finite number");
        assert!(e(&"(".repeat(5000)).message.contains("too deeply"));
        assert!(eval("1/2", &|_| Ok(0.0)).unwrap().cut_in_cpp);
        assert!(!eval("4/2", &|_| Ok(0.0)).unwrap().cut_in_cpp);
    }
}
