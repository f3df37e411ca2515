//! Formulae of place and time, as `exprFixedValue` has them: `vector(4*pos().y(), 0, 0)*sin(time())`.

mod parse;

use granflow_base::{Vec3, cross, dot, norm, scale};

pub use parse::FormulaError;

/// A number or a vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// A number.
    Scalar(f64),
    /// A vector.
    Vector(Vec3),
}

/// What a formula may ask for.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where, m.
    pub position: Vec3,
    /// Outward area vector of the face, m2.
    pub area: Vec3,
    /// When, s.
    pub time: f64,
}

/// Part of a formula.
#[derive(Clone, Debug)]
enum Node {
    Number(f64),
    /// A variable, by its place in the list.
    Variable(usize),
    Position,
    Normal,
    /// Area vector.
    Area,
    Time,
    Vector(Box<[Node; 3]>),
    Component(Box<Node>, usize),
    Minus(Box<Node>),
    Not(Box<Node>),
    Call(fn(f64) -> f64, Box<Node>),
    Call2(fn(f64, f64) -> f64, Box<[Node; 2]>),
    Length(Box<Node>),
    Binary(Op, Box<[Node; 2]>),
    Choice(Box<[Node; 3]>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Op {
    Plus,
    Minus,
    Times,
    Over,
    Rest,
    Dot,
    Cross,
    Equal,
    Unequal,
    Less,
    Greater,
    AtMost,
    AtLeast,
    And,
    Or,
}

/// Variables and a formula of them.
#[derive(Clone, Debug)]
pub struct Formula {
    variables: Vec<Node>,
    root: Node,
    /// Values of the variables at one place.
    values: Vec<Quantity>,
}

impl Formula {
    /// Understands `variables` (each `name = formula`) and `text`, whose value must be a vector or a
    /// number as `vector` says.
    ///
    /// # Errors
    /// What is wrong, and in which of them: `None` for `text`.
    pub fn new(
        variables: &[&str],
        text: &str,
        vector: bool,
    ) -> Result<Formula, (Option<usize>, FormulaError)> {
        let mut names: Vec<String> = Vec::new();
        let mut nodes = Vec::new();
        for (k, variable) in variables.iter().enumerate() {
            let (name, node) = parse::definition(variable, &names).map_err(|e| (Some(k), e))?;
            names.push(name);
            nodes.push(node);
        }
        let root = parse::formula(text, &names).map_err(|e| (None, e))?;
        let values = Vec::with_capacity(nodes.len());
        let mut out = Formula { variables: nodes, root, values };
        // Kinds do not depend on values: one trial finds every mistake.
        let trial = Place { position: [1.0; 3], area: [1.0, 0.0, 0.0], time: 1.0 };
        match (out.try_at(&trial)?, vector) {
            (Quantity::Scalar(_), false) | (Quantity::Vector(_), true) => Ok(out),
            (_, true) => {
                Err((None, FormulaError::of("a vector is needed here: `vector(x, y, z)`")))
            }
            (_, false) => Err((None, FormulaError::of("a number is needed here, not a vector"))),
        }
    }

    fn try_at(&mut self, place: &Place) -> Result<Quantity, (Option<usize>, FormulaError)> {
        self.values.clear();
        for (k, node) in self.variables.iter().enumerate() {
            let value = node.at(place, &self.values);
            self.values.push(value.map_err(|e| (Some(k), FormulaError::of(e)))?);
        }
        self.root.at(place, &self.values).map_err(|e| (None, FormulaError::of(e)))
    }

    /// The value, where it is the same everywhere and always.
    pub fn constant(&mut self) -> Option<Quantity> {
        let trial = Place { position: [1.0; 3], area: [1.0, 0.0, 0.0], time: 1.0 };
        let mut constant = Vec::with_capacity(self.variables.len());
        for node in &self.variables {
            constant.push(node.is_constant(&constant));
        }
        self.root.is_constant(&constant).then(|| self.at(&trial))
    }

    /// The value at a place.
    pub fn at(&mut self, place: &Place) -> Quantity {
        // The trial has shown that kinds fit.
        self.try_at(place).unwrap_or(Quantity::Scalar(0.0))
    }
}

type Found = Result<Quantity, &'static str>;

fn number(q: Quantity) -> Result<f64, &'static str> {
    match q {
        Quantity::Scalar(x) => Ok(x),
        Quantity::Vector(_) => Err("a number is needed and a vector found"),
    }
}

impl Quantity {
    /// Whether it consists of numbers that are finite.
    pub fn is_finite(&self) -> bool {
        match self {
            Quantity::Scalar(x) => x.is_finite(),
            Quantity::Vector(v) => v.iter().all(|x| x.is_finite()),
        }
    }
}

impl Node {
    /// Whether neither place nor time matters, where it is known of the variables.
    fn is_constant(&self, variables: &[bool]) -> bool {
        let all = |nodes: &[Node]| nodes.iter().all(|n| n.is_constant(variables));
        match self {
            Node::Number(_) => true,
            Node::Variable(k) => variables[*k],
            Node::Position | Node::Normal | Node::Area | Node::Time => false,
            Node::Vector(parts) | Node::Choice(parts) => all(&parts[..]),
            Node::Call2(_, parts) | Node::Binary(_, parts) => all(&parts[..]),
            Node::Component(n, _)
            | Node::Minus(n)
            | Node::Not(n)
            | Node::Call(_, n)
            | Node::Length(n) => n.is_constant(variables),
        }
    }

    fn at(&self, place: &Place, variables: &[Quantity]) -> Found {
        use Quantity::{Scalar, Vector};
        let of = |n: &Node| n.at(place, variables);
        Ok(match self {
            Node::Number(x) => Scalar(*x),
            Node::Variable(k) => variables[*k],
            Node::Position => Vector(place.position),
            Node::Area => Vector(place.area),
            Node::Normal => Vector(granflow_base::unit(place.area)),
            Node::Time => Scalar(place.time),
            Node::Vector(parts) => {
                let [x, y, z] = parts.each_ref().map(|n| of(n).and_then(number));
                Vector([x?, y?, z?])
            }
            Node::Component(n, c) => match of(n)? {
                Vector(v) => Scalar(v[*c]),
                Scalar(_) => return Err("a number has no components"),
            },
            Node::Minus(n) => match of(n)? {
                Scalar(x) => Scalar(-x),
                Vector(v) => Vector(scale(v, -1.0)),
            },
            Node::Not(n) => Scalar(truth(number(of(n)?)? == 0.0)),
            Node::Call(f, n) => Scalar(f(number(of(n)?)?)),
            Node::Call2(f, parts) => {
                let [a, b] = parts.each_ref().map(|n| of(n).and_then(number));
                Scalar(f(a?, b?))
            }
            Node::Length(n) => match of(n)? {
                Scalar(x) => Scalar(x.abs()),
                Vector(v) => Scalar(norm(v)),
            },
            Node::Binary(op, parts) => {
                let [a, b] = parts.each_ref().map(of);
                return op.of(a?, b?);
            }
            Node::Choice(parts) => {
                let [test, yes, no] = parts.each_ref().map(of);
                let (test, yes, no) = (number(test?)?, yes?, no?);
                if std::mem::discriminant(&yes) != std::mem::discriminant(&no) {
                    return Err("both sides of `:` must be numbers or both vectors");
                }
                if test != 0.0 { yes } else { no }
            }
        })
    }
}

fn truth(b: bool) -> f64 {
    f64::from(u8::from(b))
}

impl Op {
    fn of(self, a: Quantity, b: Quantity) -> Found {
        use Quantity::{Scalar, Vector};
        Ok(match (self, a, b) {
            (Op::Plus, Vector(a), Vector(b)) => Vector(granflow_base::add(a, b)),
            (Op::Minus, Vector(a), Vector(b)) => Vector(granflow_base::sub(a, b)),
            (Op::Times, Vector(a), Scalar(k)) | (Op::Times, Scalar(k), Vector(a)) => {
                Vector(scale(a, k))
            }
            (Op::Over, Vector(a), Scalar(k)) => Vector(scale(a, 1.0 / k)),
            (Op::Dot, Vector(a), Vector(b)) => Scalar(dot(a, b)),
            (Op::Cross, Vector(a), Vector(b)) => Vector(cross(a, b)),
            (op, Scalar(a), Scalar(b)) => Scalar(match op {
                Op::Plus => a + b,
                Op::Minus => a - b,
                Op::Times => a * b,
                Op::Over => a / b,
                Op::Rest => a % b,
                Op::Equal => truth(a == b),
                Op::Unequal => truth(a != b),
                Op::Less => truth(a < b),
                Op::Greater => truth(a > b),
                Op::AtMost => truth(a <= b),
                Op::AtLeast => truth(a >= b),
                Op::And => truth(a != 0.0 && b != 0.0),
                Op::Or => truth(a != 0.0 || b != 0.0),
                Op::Dot | Op::Cross => return Err("`&` and `^` are products of two vectors"),
            }),
            _ => return Err("numbers and vectors do not go together here"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Place = Place { position: [2.0, 3.0, 4.0], area: [0.0, -2.0, 0.0], time: 0.25 };

    fn number_of(variables: &[&str], text: &str) -> f64 {
        match Formula::new(variables, text, false).unwrap().at(&HERE) {
            Quantity::Scalar(x) => x,
            Quantity::Vector(_) => f64::NAN,
        }
    }
    fn wrong(text: &str, vector: bool) -> String {
        Formula::new(&[], text, vector).unwrap_err().1.to_string()
    }

    #[test]
    fn arithmetic_has_its_usual_order() {
        for (text, value) in [
            ("1 + 2*3 - 8/4", 5.0),
            ("-(1 - 3)*2 % 3", 1.0),
            ("2 < 3 && !(4 <= 3) || 0", 1.0),
            ("pos().x() > 1 ? 10 : 20", 10.0),
            ("1 == 2 ? 1 : 3 != 3 ? 2 : 7.5e1", 75.0),
            ("pow(2, 3) + sqrt(sqr(3)) + mag(vector(3, 4, 0)) + max(1, min(2, 3))", 18.0),
            ("pos() & vector(1, 1, 1)", 9.0),
            ("(vector(1, 0, 0) ^ vector(0, 1, 0)).z()", 1.0),
            ("normal().y() + mag(face()) + area()", 3.0),
            ("pos(3) + neg(3) + pos0(0) + sign(-2)", 1.0),
            ("cos(2*pi()*time()) + 1", 1.0),
        ] {
            assert!((number_of(&[], text) - value).abs() < 1e-12, "{text}");
        }
        let variables = ["a = 0.5", "y = pos().y()", "b = a*y"];
        assert_eq!(number_of(&variables, "b + a"), 2.0);
        let v = Formula::new(&["u = 2"], "u*vector(time(), 1, 0)/4", true).unwrap().at(&HERE);
        assert_eq!(v, Quantity::Vector([0.125, 0.5, 0.0]));
    }

    #[test]
    fn what_is_the_same_everywhere_is_known() {
        let constant = |variables: &[&str], text: &str, vector| {
            Formula::new(variables, text, vector).unwrap().constant()
        };
        assert_eq!(constant(&["a = 3"], "1 - a/2", false), Some(Quantity::Scalar(-0.5)));
        let v = Some(Quantity::Vector([0.0, 1.0, 2.0]));
        assert_eq!(constant(&[], "vector(0, 1, 2)", true), v);
        assert_eq!(constant(&["a = time()"], "1 - a/2", false), None);
        assert_eq!(constant(&[], "pos().x() > 1 ? 1 : 1", false), None);
        assert!(!constant(&[], "1/0", false).unwrap().is_finite());
        // Every variable is looked at once, however often others ask for it.
        let doubled: Vec<String> = (1..60).map(|k| format!("a{k} = a{0} + a{0}", k - 1)).collect();
        let all: Vec<&str> = ["a0 = 1"].into_iter().chain(doubled.iter().map(|s| &**s)).collect();
        assert_eq!(constant(&all, "a59", false), Some(Quantity::Scalar(2f64.powi(59))));
        assert!(!constant(&[], "vector(1, sqrt(-1), 0)", true).unwrap().is_finite());
    }

    #[test]
    fn mistakes_are_named() {
        assert!(wrong("1 +", false).contains("ends"));
        assert!(wrong("speed*2", false).contains("`speed`"));
        assert!(wrong("snGrad(U)", false).contains("`snGrad`"));
        let vector = "`vector` needs three values, `vector(x, y, z)`, not ";
        assert_eq!(wrong("vector(1, 2)", true), format!("{vector}2"));
        assert_eq!(wrong("vector()", true), format!("{vector}0"));
        assert!(wrong("1 2", false).contains("`2`"));
        assert!(wrong("pos() + 1", true).contains("numbers and vectors"));
        assert!(wrong("pos().w()", false).contains("`w`"));
        assert!(wrong("1", true).contains("a vector is needed"));
        assert!(wrong("pos()", false).contains("a number is needed"));
        assert!(wrong("1 ? pos() : 2", true).contains("both"));
        assert!(wrong(&"(".repeat(200), false).contains("deep"));
        assert_eq!(Formula::new(&["a = 1", "b"], "a", false).unwrap_err().0, Some(1));
    }
}
