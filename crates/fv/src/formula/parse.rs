//! From text to a formula.

use super::{Node, Op};
use granflow_dict::nearest;

/// What is wrong with a formula.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct FormulaError(String);

impl FormulaError {
    pub(super) fn of(text: impl Into<String>) -> Self {
        FormulaError(text.into())
    }
}

/// Most characters of a formula.
const LONGEST: usize = 10_000;

type Parsed = Result<Node, FormulaError>;

/// A function of one number.
type One = fn(f64) -> f64;
/// A function of two numbers.
type Two = fn(f64, f64) -> f64;

/// Functions of one number.
const ONE: &[(&str, One)] = &[
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("exp", f64::exp),
    ("log", f64::ln),
    ("log10", f64::log10),
    ("sqrt", f64::sqrt),
    ("sqr", |x| x * x),
    ("cbrt", f64::cbrt),
    ("floor", f64::floor),
    ("ceil", f64::ceil),
    ("round", f64::round),
    ("degToRad", f64::to_radians),
    ("radToDeg", f64::to_degrees),
    ("sign", |x| if x >= 0.0 { 1.0 } else { -1.0 }),
    ("pos", |x| if x > 0.0 { 1.0 } else { 0.0 }),
    ("pos0", |x| if x >= 0.0 { 1.0 } else { 0.0 }),
    ("neg", |x| if x < 0.0 { 1.0 } else { 0.0 }),
    ("neg0", |x| if x <= 0.0 { 1.0 } else { 0.0 }),
];

/// Functions of two numbers.
const TWO: &[(&str, Two)] = &[
    ("pow", f64::powf),
    ("min", f64::min),
    ("max", f64::max),
    ("atan2", f64::atan2),
    ("hypot", f64::hypot),
    ("fmod", |a, b| a % b),
];

/// What formulae know beside functions of numbers.
const OTHER: &[&str] = &["vector", "mag", "magSqr", "time", "pi", "face", "area", "normal"];

/// How deep parentheses may go.
const MOST_DEEP: usize = 100;

struct Parser<'t> {
    rest: &'t str,
    names: &'t [String],
    depth: usize,
}

/// The name and the formula of `name = formula`.
pub(super) fn definition(text: &str, names: &[String]) -> Result<(String, Node), FormulaError> {
    let (name, value) = text
        .split_once('=')
        .ok_or_else(|| FormulaError::of("a variable is written `name = formula`"))?;
    let name = name.trim();
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.is_empty() || !name.chars().all(word) {
        return Err(FormulaError::of(format!("`{name}` is no name of a variable")));
    }
    Ok((name.to_owned(), formula(value, names)?))
}

/// A formula of the variables `names`.
pub(super) fn formula(text: &str, names: &[String]) -> Parsed {
    // Every operation is a call deeper when it is evaluated.
    if text.len() > LONGEST {
        let message =
            format!("a formula of {} characters is too long: {LONGEST} at most", text.len());
        return Err(FormulaError::of(message));
    }
    let mut p = Parser { rest: text.trim_end().trim_end_matches(';'), names, depth: 0 };
    let node = p.choice()?;
    p.space();
    match p.rest {
        "" => Ok(node),
        rest => Err(FormulaError::of(format!("`{}` is not expected", brief(rest)))),
    }
}

fn brief(rest: &str) -> String {
    rest.chars().take(12).collect()
}

impl<'t> Parser<'t> {
    fn space(&mut self) {
        self.rest = self.rest.trim_start();
    }
    /// Takes the first of `ops` that stands here.
    fn take<T: Copy>(&mut self, ops: &[(&str, T)]) -> Option<T> {
        self.space();
        let (op, what) = ops.iter().find(|(op, _)| self.rest.starts_with(op))?;
        self.rest = &self.rest[op.len()..];
        Some(*what)
    }
    fn need(&mut self, what: &str) -> Result<(), FormulaError> {
        match self.take(&[(what, ())]) {
            Some(()) => Ok(()),
            None => Err(self.expected(&format!("`{what}`"))),
        }
    }
    fn expected(&self, what: &str) -> FormulaError {
        FormulaError::of(match self.rest {
            "" => format!("the formula ends where {what} is needed"),
            rest => format!("{what} is needed at `{}`", brief(rest)),
        })
    }
    fn choice(&mut self) -> Parsed {
        self.depth += 1;
        if self.depth > MOST_DEEP {
            return Err(FormulaError::of("the formula is nested too deeply"));
        }
        let mut out = self.binary(0)?;
        if self.take(&[("?", ())]).is_some() {
            let yes = self.choice()?;
            self.need(":")?;
            out = Node::Choice(Box::new([out, yes, self.choice()?]));
        }
        self.depth -= 1;
        Ok(out)
    }
    fn binary(&mut self, level: usize) -> Parsed {
        /// From what binds least to what binds most; longer ones before those they begin with.
        const LEVELS: &[&[(&str, Op)]] = &[
            &[("||", Op::Or)],
            &[("&&", Op::And)],
            &[
                ("==", Op::Equal),
                ("!=", Op::Unequal),
                ("<=", Op::AtMost),
                (">=", Op::AtLeast),
                ("<", Op::Less),
                (">", Op::Greater),
            ],
            &[("+", Op::Plus), ("-", Op::Minus)],
            &[("*", Op::Times), ("/", Op::Over), ("%", Op::Rest), ("^", Op::Cross), ("&", Op::Dot)],
        ];
        let Some(ops) = LEVELS.get(level) else { return self.unary() };
        let mut out = self.binary(level + 1)?;
        loop {
            self.space();
            // `&&` is no `&` with another behind it.
            if level == LEVELS.len() - 1 && self.rest.starts_with("&&") {
                return Ok(out);
            }
            let Some(op) = self.take(ops) else { return Ok(out) };
            out = Node::Binary(op, Box::new([out, self.binary(level + 1)?]));
        }
    }
    fn unary(&mut self) -> Parsed {
        // A loop, not a recursion: `------1` must not exhaust the stack.
        let mut signs = Vec::new();
        while let Some(sign) = self.take(&[("-", '-'), ("+", '+'), ("!", '!')]) {
            signs.push(sign);
        }
        let mut out = self.atom()?;
        while self.take(&[(".", ())]).is_some() {
            let name = self.name();
            let c = ["x", "y", "z"].iter().position(|n| *n == name);
            let c = c.ok_or_else(|| {
                FormulaError::of(format!("`{name}` is no component: `.x()`, `.y()`, `.z()`"))
            })?;
            self.need("(")?;
            self.need(")")?;
            out = Node::Component(Box::new(out), c);
        }
        for sign in signs.into_iter().rev() {
            out = match sign {
                '-' => Node::Minus(Box::new(out)),
                '!' => Node::Not(Box::new(out)),
                _ => out,
            };
        }
        Ok(out)
    }
    fn name(&mut self) -> &'t str {
        self.space();
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let end = self.rest.find(|c| !word(c)).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        name
    }
    fn atom(&mut self) -> Parsed {
        if self.take(&[("(", ())]).is_some() {
            let inner = self.choice()?;
            self.need(")")?;
            return Ok(inner);
        }
        if self.rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return self.number();
        }
        let name = self.name();
        if name.is_empty() {
            return Err(self.expected("a value"));
        }
        if let Some(k) = self.names.iter().rposition(|n| n == name) {
            return Ok(Node::Variable(k));
        }
        if self.take(&[("(", ())]).is_none() {
            return Err(self.unknown(name, "no variable"));
        }
        let functions = ONE.iter().map(|f| f.0).chain(TWO.iter().map(|f| f.0));
        if !functions.chain(OTHER.iter().copied()).any(|f| f == name) {
            return Err(self.unknown(name, "no function that is known here"));
        }
        self.call(name)
    }
    fn number(&mut self) -> Parsed {
        let bytes = self.rest.as_bytes();
        let mut end = 0;
        while let Some(c) = bytes.get(end) {
            let sign = matches!(c, b'+' | b'-') && matches!(bytes[end.max(1) - 1], b'e' | b'E');
            if !(c.is_ascii_digit() || matches!(c, b'.' | b'e' | b'E') || sign) {
                break;
            }
            end += 1;
        }
        let (text, rest) = self.rest.split_at(end);
        let x = text.parse().map_err(|_| FormulaError::of(format!("`{text}` is no number")))?;
        self.rest = rest;
        Ok(Node::Number(x))
    }
    /// The values between the parentheses behind a name.
    fn arguments(&mut self) -> Result<Vec<Node>, FormulaError> {
        let mut out = Vec::new();
        if self.take(&[(")", ())]).is_some() {
            return Ok(out);
        }
        loop {
            out.push(self.choice()?);
            if self.take(&[(",", ())]).is_none() {
                self.need(")")?;
                return Ok(out);
            }
        }
    }
    fn call(&mut self, name: &str) -> Parsed {
        let arguments = self.arguments()?;
        let n = arguments.len();
        let mut each = arguments.into_iter();
        let wrong = |needs: &str| FormulaError::of(format!("`{name}` needs {needs}, not {n}"));
        let mut one = || each.next().map(Box::new);
        if n == 0 && name != "vector" {
            let area = || Box::new(Node::Area);
            return match name {
                "pos" => Ok(Node::Position),
                "time" => Ok(Node::Time),
                "pi" => Ok(Node::Number(std::f64::consts::PI)),
                "face" => Ok(Node::Area),
                "area" => Ok(Node::Length(area())),
                "normal" => Ok(Node::Normal),
                _ => Err(wrong("values between its parentheses")),
            };
        }
        if let Some((_, f)) = ONE.iter().find(|f| f.0 == name) {
            return match (one(), n) {
                (Some(x), 1) => Ok(Node::Call(*f, x)),
                _ => Err(wrong("one value")),
            };
        }
        if let Some((_, f)) = TWO.iter().find(|f| f.0 == name) {
            return match (each.next(), each.next(), n) {
                (Some(a), Some(b), 2) => Ok(Node::Call2(*f, Box::new([a, b]))),
                _ => Err(wrong("two values")),
            };
        }
        match (name, n) {
            ("mag", 1) => one().map(Node::Length).ok_or_else(|| wrong("one value")),
            ("magSqr", 1) => {
                let length = one().map(Node::Length).ok_or_else(|| wrong("one value"))?;
                Ok(Node::Call(|x| x * x, Box::new(length)))
            }
            ("vector", 3) => match (each.next(), each.next(), each.next()) {
                (Some(x), Some(y), Some(z)) => Ok(Node::Vector(Box::new([x, y, z]))),
                _ => Err(wrong("three values")),
            },
            ("vector", _) => Err(wrong("three values, `vector(x, y, z)`")),
            _ => Err(wrong("no values between its parentheses")),
        }
    }
    fn unknown(&self, name: &str, what: &str) -> FormulaError {
        let functions = ONE.iter().map(|f| f.0).chain(TWO.iter().map(|f| f.0));
        let known = functions.chain(OTHER.iter().copied());
        let known = known.chain(self.names.iter().map(String::as_str));
        let near = nearest(name, known);
        let near = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
        FormulaError::of(format!("`{name}` is {what}{near}"))
    }
}
