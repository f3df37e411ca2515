//! The valid word a user most likely meant.

/// The choice nearest to `word`: equal but for case first, then the smallest edit distance that is
/// small against the word's length. `None` when nothing is close.
pub fn nearest<'c>(word: &str, choices: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let lower = word.to_lowercase();
    let limit = 1 + word.chars().count() / 3;
    let mut best: Option<(usize, &'c str)> = None;
    for choice in choices {
        let other = choice.to_lowercase();
        let d = if lower == other { 0 } else { 1 + distance(&lower, &other) };
        if d <= limit + 1 && best.is_none_or(|(b, _)| d < b) && d < 1 + other.chars().count().max(2)
        {
            best = Some((d, choice));
        }
    }
    best.map(|(_, c)| c)
}

/// Edit distance that counts a swap of neighbours as one slip (optimal string alignment,
/// Damerau 1964).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let width = b.len() + 1;
    let mut rows = vec![0; (a.len() + 1) * width];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            let at = i * width + j;
            rows[at] = if i == 0 || j == 0 {
                i + j
            } else {
                let same = usize::from(a[i - 1] != b[j - 1]);
                let mut d = rows[at - width - 1] + same;
                d = d.min(rows[at - width] + 1).min(rows[at - 1] + 1);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    d = d.min(rows[at - 2 * width - 2] + 1);
                }
                d
            };
        }
    }
    rows[a.len() * width + b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn case_comes_first_then_few_slips_then_nothing() {
        let known = ["GAMG", "PCG", "PBiCGStab", "smoothSolver"];
        assert_eq!(nearest("pbicgstab", known), Some("PBiCGStab"));
        assert_eq!(nearest("GMAG", known), Some("GAMG"));
        assert_eq!(nearest("smothSolver", known), Some("smoothSolver"));
        assert_eq!(nearest("banana", known), None);
        assert_eq!(nearest("mu", ["I0", "A"]), None);
    }

    #[test]
    fn swaps_count_once() {
        assert_eq!(distance("abcd", "abdc"), 1);
        assert_eq!(distance("", "abc"), 3);
    }
}
