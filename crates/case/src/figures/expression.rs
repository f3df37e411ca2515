//! Arithmetic on columns: `(x - 0.051)/0.00075`, `U_y/max(U_y)`, `log10(abs(V))`.
//!
//! `+ - * / ^`, parentheses, numbers, names of columns (in backquotes when they hold other than
//! letters, digits and `_`), `abs sqrt exp log log10 sin cos`, and over the whole column
//! `max min mean first last`. `mag(U)` is the length of the vector with the columns `U_x U_y U_z`,
//! `mag(x)` of anything else its absolute value.
//! Names may hold dots: `alpha.grains`.

use super::table::Table;
use std::cell::RefCell;

/// What is wrong with an expression.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExpressionError {
    /// A name that is no column and no function.
    #[error("there is no column `{name}`; the columns are {}", known.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// Something else is needed here.
    #[error("expected {expected} at `{found}`")]
    Expected {
        /// What.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// Too many parentheses.
    #[error("the expression is nested too deeply")]
    Depth,
}

/// Evaluates `text` for every row of `table`.
///
/// # Errors
/// [`ExpressionError`].
pub fn evaluate(text: &str, table: &Table) -> Result<Vec<f64>, ExpressionError> {
    Parser::new(text, Some(table)).whole()
}

/// Looks for mistakes before there are data: any name may be a column.
///
/// # Errors
/// [`ExpressionError`].
pub fn check(text: &str) -> Result<(), ExpressionError> {
    Parser::new(text, None).whole().map(drop)
}

/// The names of the columns it needs, each once.
///
/// # Errors
/// [`ExpressionError`].
pub fn names(text: &str) -> Result<Vec<String>, ExpressionError> {
    let seen = RefCell::new(Vec::new());
    Parser { seen: Some(&seen), ..Parser::new(text, None) }.whole()?;
    let mut names = seen.into_inner();
    names.sort();
    names.dedup();
    Ok(names)
}

struct Parser<'t> {
    rest: &'t str,
    /// `None`: only the form of the expression matters.
    table: Option<&'t Table>,
    n: usize,
    depth: usize,
    /// Collects the names of columns.
    seen: Option<&'t RefCell<Vec<String>>>,
}

/// Whether a text is the name of a column rather than an expression.
fn is_name(text: &str) -> bool {
    let word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | ':');
    text.starts_with(|c: char| c.is_alphabetic()) && text.chars().all(word)
}

type Column = Result<Vec<f64>, ExpressionError>;

fn zip(a: Vec<f64>, b: &[f64], f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.into_iter().zip(b).map(|(x, y)| f(x, *y)).collect()
}

impl<'t> Parser<'t> {
    fn new(text: &'t str, table: Option<&'t Table>) -> Parser<'t> {
        let n = table.and_then(|t| t.columns.first()).map_or(0, Vec::len);
        Parser { rest: text, table, n, depth: 0, seen: None }
    }
    fn whole(mut self) -> Column {
        let v = self.sum()?;
        self.skip();
        if self.rest.is_empty() { Ok(v) } else { self.expected("an operator") }
    }
    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }
    fn expected<T>(&self, expected: &'static str) -> Result<T, ExpressionError> {
        let found: String = self.rest.chars().take(12).collect();
        let found = if found.is_empty() { "the end".into() } else { found };
        Err(ExpressionError::Expected { expected, found })
    }
    fn take(&mut self, c: char) -> bool {
        self.skip();
        match self.rest.strip_prefix(c) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }
    fn sum(&mut self) -> Column {
        self.depth += 1;
        if self.depth > 60 {
            return Err(ExpressionError::Depth);
        }
        let mut x = self.product()?;
        loop {
            if self.take('+') {
                x = zip(x, &self.product()?, |a, b| a + b);
            } else if self.take('-') {
                x = zip(x, &self.product()?, |a, b| a - b);
            } else {
                self.depth -= 1;
                return Ok(x);
            }
        }
    }
    fn product(&mut self) -> Column {
        let mut x = self.signed()?;
        loop {
            if self.take('*') {
                x = zip(x, &self.signed()?, |a, b| a * b);
            } else if self.take('/') {
                x = zip(x, &self.signed()?, |a, b| a / b);
            } else {
                return Ok(x);
            }
        }
    }
    fn signed(&mut self) -> Column {
        if self.take('-') {
            self.depth += 1;
            if self.depth > 60 {
                return Err(ExpressionError::Depth);
            }
            let x = self.signed()?;
            self.depth -= 1;
            return Ok(x.into_iter().map(|x| -x).collect());
        }
        let x = self.atom()?;
        if self.take('^') {
            return Ok(zip(x, &self.signed()?, f64::powf));
        }
        Ok(x)
    }
    fn atom(&mut self) -> Column {
        if self.take('(') {
            let x = self.sum()?;
            return if self.take(')') { Ok(x) } else { self.expected("`)`") };
        }
        if self.take('`') {
            let Some((name, rest)) = self.rest.split_once('`') else {
                return self.expected("a closing backquote");
            };
            self.rest = rest;
            return self.column(name);
        }
        let digits = self.number_length();
        if digits > 0 {
            let (number, rest) = self.rest.split_at(digits);
            let Ok(x) = number.parse::<f64>() else { return self.expected("a number") };
            self.rest = rest;
            return Ok(vec![x; self.n]);
        }
        let word = |c: char| !(c.is_alphanumeric() || matches!(c, '_' | '.' | ':'));
        let end = self.rest.find(word).unwrap_or(self.rest.len());
        if end == 0 {
            return self.expected("a number, a column or `(`");
        }
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        if rest.trim_start().starts_with('(') {
            return self.call(name);
        }
        self.column(name)
    }
    /// Length of the number that stands here: `1`, `.5`, `1e-3`.
    fn number_length(&self) -> usize {
        let b = self.rest.as_bytes();
        if !b.first().is_some_and(|c| c.is_ascii_digit() || *c == b'.') {
            return 0;
        }
        let digits = |mut i: usize| {
            while b.get(i).is_some_and(|c| c.is_ascii_digit() || *c == b'.') {
                i += 1;
            }
            i
        };
        let end = digits(0);
        if matches!(b.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(b.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits(end + 1 + sign);
            if exponent > end + 1 + sign {
                return exponent;
            }
        }
        end
    }
    fn column(&self, name: &str) -> Column {
        if let Some(seen) = self.seen {
            seen.borrow_mut().push(name.to_owned());
        }
        let Some(table) = self.table else { return Ok(Vec::new()) };
        match table.column(name) {
            Some(i) => Ok(table.columns[i].clone()),
            None if name == "pi" => Ok(vec![std::f64::consts::PI; self.n]),
            None => {
                Err(ExpressionError::Unknown { name: name.to_owned(), known: table.names.clone() })
            }
        }
    }
    /// The length of the vector `name`, or the size of the column of that name.
    fn size(&self, name: &str) -> Column {
        let whole = format!("mag({name})");
        let Some(table) = self.table else { return self.column(&whole) };
        if table.column(&whole).is_some() {
            return self.column(&whole);
        }
        let part = |axis: &str| table.column(&format!("{name}_{axis}"));
        if let (Some(x), Some(y), Some(z)) = (part("x"), part("y"), part("z")) {
            let of = |k: usize| &table.columns[k];
            let row = |i: usize| of(x)[i].hypot(of(y)[i]).hypot(of(z)[i]);
            return Ok((0..self.n).map(row).collect());
        }
        Ok(self.column(name)?.into_iter().map(f64::abs).collect())
    }
    fn call(&mut self, name: &str) -> Column {
        self.take('(');
        if name == "mag"
            && let Some((inside, rest)) = self.rest.split_once(')')
            && is_name(inside.trim())
        {
            self.rest = rest;
            return self.size(inside.trim());
        }
        let x = self.sum()?;
        if !self.take(')') {
            return self.expected("`)`");
        }
        let map = |f: fn(f64) -> f64| Ok(x.iter().map(|x| f(*x)).collect());
        let all = |v: f64| Ok(vec![v; x.len()]);
        match name {
            "abs" | "mag" => map(f64::abs),
            "sqrt" => map(f64::sqrt),
            "exp" => map(f64::exp),
            "log" => map(f64::ln),
            "log10" => map(f64::log10),
            "sin" => map(f64::sin),
            "cos" => map(f64::cos),
            "max" => all(x.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            "min" => all(x.iter().copied().fold(f64::INFINITY, f64::min)),
            "mean" => all(x.iter().sum::<f64>() / x.len() as f64),
            "first" => all(x.first().copied().unwrap_or(f64::NAN)),
            "last" => all(x.last().copied().unwrap_or(f64::NAN)),
            _ => Err(ExpressionError::Expected {
                expected: "one of abs sqrt exp log log10 sin cos mag max min mean first last",
                found: name.to_owned(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Vec<f64> {
        evaluate(text, &Table::parse("# x U_y V/Vw\n1 2 3\n4 8 6\n")).unwrap()
    }

    #[test]
    fn arithmetic_on_columns() {
        assert_eq!(value("(x - 0.5)/0.5"), [1.0, 7.0]);
        assert_eq!(value("U_y/max(U_y)"), [0.25, 1.0]);
        assert_eq!(value("-x^2 + 1e1*2"), [19.0, 4.0]);
        assert_eq!(value("`V/Vw` - first(x)"), [2.0, 5.0]);
        assert_eq!(value("abs(-x) + sqrt(4)"), [3.0, 6.0]);
        assert_eq!(value("2^-1"), [0.5, 0.5]);
        assert_eq!(value("col3"), [3.0, 6.0]);
    }

    #[test]
    fn vectors_and_names_with_dots() {
        let t = Table::parse("# U_x U_y U_z a.b\n3 4 12 7\n");
        assert_eq!(evaluate("mag( U )/13 + a.b", &t).unwrap(), [8.0]);
        assert_eq!(evaluate("mag(U_x - 10) + mag(a.b)", &t).unwrap(), [14.0]);
        assert_eq!(names("mag(U) + max(a.b)*pi + U_x").unwrap(), ["U_x", "a.b", "mag(U)", "pi"]);
        assert!(evaluate("mag(V)", &t).is_err() && check("mag(U").is_err());
    }

    #[test]
    fn mistakes_are_named() {
        let t = Table::parse("# x y\n1 2\n");
        let error = |s: &str| evaluate(s, &t).unwrap_err().to_string();
        assert_eq!(error("x + z"), "there is no column `z`; the columns are x, y");
        assert_eq!(error("(x"), "expected `)` at `the end`");
        assert!(error("tan(x)").contains("expected one of abs"));
        assert!(evaluate(&"(".repeat(10_000), &t).is_err());
        assert!(evaluate(&"-".repeat(100_000), &t).is_err());
        assert_eq!(check("mean(z)/`V/Vw` + pi*col1 - last(y)"), Ok(()), "any name may be a column");
        assert!(check("(x").is_err() && check("tan(x)").is_err() && check("x y").is_err());
    }
}
