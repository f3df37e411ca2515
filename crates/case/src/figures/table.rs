//! Tables of numbers as text: what functions write, and reference data in CSV.

/// Columns of numbers with their names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// One name a column; `col1`, `col2`, .. where the file gives none.
    pub names: Vec<String>,
    /// The columns, all of one length.
    pub columns: Vec<Vec<f64>>,
}

impl Table {
    /// Reads a text: `#` starts a comment, the last one before the numbers names the columns if
    /// it has as many words; else a first line that is not numbers does. Columns are separated by
    /// commas, or by blanks; parentheses of vectors do not count. Lines that do not begin with a number are
    /// left out.
    pub fn parse(text: &str) -> Table {
        let mut table = Table::default();
        let mut heads: Vec<Vec<String>> = Vec::new();
        for line in text.lines() {
            let line = line.trim();
            if let Some(comment) = line.strip_prefix('#') {
                if table.columns.is_empty() {
                    heads.push(split(comment));
                }
                continue;
            }
            let words = split(line);
            let numbers = row(&words);
            match numbers {
                Some(n) if !n.is_empty() => {
                    if table.columns.is_empty() {
                        table.columns = vec![Vec::new(); n.len()];
                    }
                    if n.len() == table.columns.len() {
                        table.columns.iter_mut().zip(n).for_each(|(c, x)| c.push(x));
                    }
                }
                _ if table.columns.is_empty() && !words.is_empty() => heads.push(words),
                _ => {}
            }
        }
        let n = table.columns.len();
        let fits = |h: &Vec<String>| h.len() == n;
        table.names = heads
            .into_iter()
            .rev()
            .find(fits)
            .unwrap_or_else(|| (1..=n).map(|i| format!("col{i}")).collect());
        table
    }

    /// The column called `name`, or `colN` by its number. `U_x` finds `U_0` as well.
    pub fn column(&self, name: &str) -> Option<usize> {
        let by_number = || {
            let i: usize = name.strip_prefix("col")?.parse().ok()?;
            (1..=self.columns.len()).contains(&i).then(|| i - 1)
        };
        // OpenFOAM's csv files number the components of vectors.
        let numbered = || {
            let (vector, axis) = name.rsplit_once('_')?;
            let k = ["x", "y", "z"].iter().position(|a| *a == axis)?;
            let wanted = format!("{vector}_{k}");
            self.names.iter().position(|n| *n == wanted)
        };
        let named = self.names.iter().position(|n| n == name);
        named.or_else(numbered).or_else(by_number)
    }
}

/// The numbers of a line that begins with one. Words among them, such as the name of a solver, are no
/// numbers; `true` and `false` are 1 and 0.
fn row(words: &[String]) -> Option<Vec<f64>> {
    words.first()?.parse::<f64>().ok()?;
    let number = |w: &String| match w.as_str() {
        "true" => 1.0,
        "false" => 0.0,
        _ => w.parse().unwrap_or(f64::NAN),
    };
    Some(words.iter().map(number).collect())
}

fn split(line: &str) -> Vec<String> {
    let clean = |w: &str| w.trim().trim_matches('"').to_owned();
    if line.contains(',') {
        return line.split(',').map(clean).collect();
    }
    let bare = line.replace(['(', ')'], " ");
    bare.split_whitespace().map(clean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_with_comments_and_a_header() {
        let t = Table::parse("# annular cell\n# Ri, Ro\nr_over_d,V\n0,1\n1.5,6e-1\n");
        assert_eq!(t.names, ["r_over_d", "V"]);
        assert_eq!(t.columns, [vec![0.0, 1.5], vec![1.0, 0.6]]);
        assert_eq!((t.column("V"), t.column("col1"), t.column("col3")), (Some(1), Some(0), None));
    }

    #[test]
    fn words_among_numbers_take_no_column_away() {
        let t = Table::parse("# Time\tU_solver\tU_initial\tU_converged\n0.1\tDICPCG\t1e-2\ttrue\n");
        assert_eq!((t.columns[0][0], t.columns[2][0], t.columns[3][0]), (0.1, 0.01, 1.0));
        assert!(t.columns[1][0].is_nan());
        let t = Table::parse("y,U_0,U_1,U_2\n0.5,3,4,5\n");
        assert_eq!((t.column("U_x"), t.column("U_z"), t.column("V_x")), (Some(1), Some(3), None));
    }

    #[test]
    fn vectors_in_parentheses() {
        let t = Table::parse("# Force\n# Time\t(fx fy fz)\n0.1\t(1 2 3)\n0.2\t(4 5 6)\nbroken 1\n");
        assert_eq!(t.names, ["Time", "fx", "fy", "fz"]);
        assert_eq!(t.columns[3], [3.0, 6.0]);
    }
}
