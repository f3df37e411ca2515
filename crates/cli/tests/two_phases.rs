//! Cases with two phases through the command: fields are set, restarts and threads change no bit.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail, and prints")]

mod common;

use common::{Case, collapse, dam, of_catalogue, text};
use granflow_case::{Event, Notices, Options, Run};
use granflow_dict::Sink;

fn ran(case: &Case, args: &[&str]) {
    let run = case.run(args);
    assert!(run.status.success(), "{}", text(&run.stderr));
}

#[test]
fn fields_are_set_and_written() {
    let case = dam();
    ran(&case, &["init"]);
    let alpha = case.read("0/alpha.water");
    assert!(alpha.contains("nonuniform List<scalar>"), "{alpha}");
    // 16 cells over 5 widths, 8 over 2.5: the column covers 3 x 6 of their centres.
    let inside = alpha.split("boundaryField").next().unwrap();
    let ones = inside.lines().filter(|l| *l == "1").count();
    assert_eq!(ones, 18, "{alpha}");
    ran(&case, &["run"]);
    assert_eq!(case.read("0/alpha.water"), alpha, "what is set stays");
    let p = case.read("0.02/p");
    assert!(p.contains("[1 -1 -2 0 0 0 0]"), "{p}");
}

#[test]
fn a_fraction_beyond_its_bounds_is_refused() {
    let case = dam();
    ran(&case, &["init"]);
    let file = case.path().join("0/alpha.water");
    let old = case.read("0/alpha.water");
    std::fs::write(&file, old.replacen("\n1\n", "\n1.5\n", 1)).unwrap();
    let run = case.run(&["run"]);
    let said = text(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(
        said.contains("0/alpha.water") && said.contains("the volume fraction is 1.5"),
        "{said}"
    );
    // So is what `setFieldsDict` makes of it.
    let set =
        dam().edit("system/setFieldsDict", "alpha.water 1", "alpha.water 1.05").run(&["check"]);
    let said = text(&set.stderr);
    assert_eq!(set.status.code(), Some(2), "{said}");
    assert!(said.contains("the volume fraction is 1.05"), "{said}");
}

/// What loose tolerances leave in a state that a run has written is taken, and said.
#[test]
fn a_fraction_a_little_beyond_its_bounds_restarts() {
    let case = dam();
    ran(&case, &["run", "--until", "0.01"]);
    let file = case.path().join("0.01/alpha.water");
    let old = case.read("0.01/alpha.water");
    assert!(old.contains("\n1\n"), "{old}");
    std::fs::write(&file, old.replacen("\n1\n", "\n1.01\n", 1)).unwrap();
    let run = case.run(&["check"]);
    let said = text(&run.stderr);
    assert_eq!(run.status.code(), Some(0), "{said}");
    assert!(said.contains("warning") && said.contains("the volume fraction is 1.01"), "{said}");
    std::fs::write(&file, old.replacen("\n1\n", "\n1.2\n", 1)).unwrap();
    assert_eq!(case.run(&["check"]).status.code(), Some(2));
}

#[test]
fn a_restart_repeats_the_run_to_the_bit() {
    for application in ["interFoam", "interIsoFoam"] {
        let files = ["0.02/U", "0.02/p_rgh", "0.02/alpha.water", "0.02/phi", "0.02/uniform/time"];
        let case = || dam().edit("system/controlDict", "interFoam", application);
        let whole = case();
        ran(&whole, &["run", "-j", "1"]);
        let halves = case();
        ran(&halves, &["run", "-j", "1", "--until", "0.01"]);
        ran(&halves, &["run", "-j", "3", "--share", "1"]);
        for file in files {
            assert_eq!(whole.read(file), halves.read(file), "{application}: {file}");
        }
    }
}

/// Everything that they start from is in the fields: the fluidity, and where the grains have only just come.
#[test]
fn a_restart_of_grains_in_air_repeats_the_run_to_the_bit() {
    let coefficients = "mus  0.32;";
    for model in ["muI", "NGF"] {
        let mut files = vec!["0.01/U", "0.01/p_rgh", "0.01/alpha.grains", "0.01/phi"];
        if model == "NGF" {
            files.push("0.01/fluidity");
        }
        let case = || {
            let case = collapse();
            if model == "muI" {
                return case;
            }
            case.edit("constant/transportProperties", "transportModel muI;", "transportModel NGF;")
                .edit("constant/transportProperties", "muICoeffs", "NGFCoeffs")
                .edit("constant/transportProperties", coefficients, "A 0.48; mus 0.32;")
        };
        let whole = case();
        ran(&whole, &["run", "-j", "1"]);
        let halves = case();
        ran(&halves, &["run", "-j", "1", "--until", "0.005"]);
        ran(&halves, &["run", "-j", "3", "--share", "1"]);
        for file in files {
            assert!(whole.read(file) == halves.read(file), "{model}: {file}");
        }
    }
}

#[test]
fn ranks_agree_with_one() {
    let loosest = ["tolerance       1e-8;", "U 1e-6; p 1e-6; viscosity 1e-4;"];
    let tightest = ["tolerance       1e-12;", "U 1e-10; p 1e-10; viscosity 1e-8;"];
    for (of, file, k) in
        [(dam as fn() -> Case, "0.02/alpha.water", 0), (collapse, "0.01/alpha.grains", 1)]
    {
        let run = |ranks: usize| {
            let case = of().edit("system/fvSolution", loosest[k], tightest[k]);
            ran(&case, &["init"]);
            let options = Options { ranks, ..Options::default() };
            let mut run = Run::load(case.path(), &options, &Sink::new(), &Notices::new())
                .expect("a sound case");
            while !matches!(run.advance().expect("a step"), Event::Done(_)) {}
            let alpha = case.read(file);
            let cells =
                alpha.lines().filter_map(|l| l.trim().parse::<f64>().ok()).collect::<Vec<_>>();
            assert!(cells.len() >= 75);
            cells
        };
        let (one, three) = (run(1), run(3));
        let apart = one.iter().zip(&three).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6, "{file}: {apart:e}");
    }
}

/// Grains with a fluidity, one rank without any of them: a heap under a fluid, its steady state and marching from it.
#[test]
fn ranks_agree_where_grains_have_a_fluidity() {
    let run = |ranks: usize| {
        let case = of_catalogue("heap_flow")
            .edit("system/blockMeshDict", "(2 19 60) simple", "(1 19 60) simple")
            .edit("system/fvSchemes", "Euler", "steadyState")
            .edit("system/controlDict", "endTime         1.4;", "endTime         0.02;")
            .edit("system/controlDict", "writeInterval   0.7;", "writeInterval   0.02;")
            .edit("system/fvSolution", "viscosity 1e-7", "viscosity 1e-8");
        let go = |case: &Case| {
            let options = Options { ranks, ..Options::default() };
            let sink = Sink::new();
            let mut run = Run::load(case.path(), &options, &sink, &Notices::new())
                .unwrap_or_else(|e| panic!("{e}: {}", sink.take()));
            while !matches!(run.advance().expect("a step"), Event::Done(_)) {}
        };
        go(&case);
        let steady = case.read("0.02/U");
        let case = case
            .edit("system/fvSchemes", "steadyState", "Euler")
            .edit("system/controlDict", "startFrom       startTime;", "startFrom latestTime;")
            .edit("system/controlDict", "endTime         0.02;", "endTime         0.04;");
        go(&case);
        let numbers = |text: &str| {
            let list = text.split("boundaryField").next().unwrap().to_owned();
            let words = list.split(['(', ')', ' ', '\n']).map(str::to_owned).collect::<Vec<_>>();
            words.iter().filter_map(|w| w.parse::<f64>().ok()).collect::<Vec<_>>()
        };
        [numbers(&steady), numbers(&case.read("0.04/U"))]
    };
    let (one, three) = (run(1), run(3));
    for (a, b) in one.iter().zip(&three) {
        assert!(a.len() > 900 && a.len() == b.len());
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("apart by {apart:e} m/s of 0.16");
        // 1.1e-6 found, with residuals of 1e-11 as well. It is not the ranks: with those one rank that begins again from its own steady state
        // moves by 7e-7. Steady states of heaps are no more unique than that (book, "Two fluids").
        assert!(apart < 2e-6, "{apart:e}");
    }
}

/// What leaves through the opening is what the tank loses.
#[test]
fn a_silo_begins_to_empty() {
    let dir = tempfile::tempdir().unwrap();
    let new = common::granflow(&["new", "silo", "silo"]).current_dir(dir.path()).output().unwrap();
    assert!(new.status.success(), "{}", text(&new.stderr));
    let at = dir.path().join("silo");
    let mesh = std::fs::read_to_string(at.join("system/blockMeshDict")).unwrap();
    let coarse = [
        ("opening         7;", "opening         4;"),
        ("{ 32 - ", "{ 16 - "),
        ("2.5/32", "2.5/16"),
        (" 64 1)", " 32 1)"),
    ];
    let mesh = coarse.iter().fold(mesh, |mesh, (fine, coarse)| {
        assert!(mesh.contains(fine), "{fine}");
        mesh.replace(fine, coarse)
    });
    std::fs::write(at.join("system/blockMeshDict"), mesh).unwrap();
    let run =
        common::granflow(&["run", "-j", "1", "--until", "0.05"]).current_dir(&at).output().unwrap();
    let said = format!("{}{}", text(&run.stdout), text(&run.stderr));
    assert!(run.status.success() && !said.contains("not converged"), "{said}");
    let table = std::fs::read_to_string(at.join("postProcessing/grains/0/phase.dat")).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| l.split_whitespace().map(|x| x.parse().unwrap()).collect())
        .collect();
    assert!(rows.len() > 5, "{table}");
    // What leaves is what is lost (the interface moves before the flow does); from rest, in free fall.
    let (mut left, mut before) = (0.0, [0.0, 0.0]);
    for row in &rows {
        let (now, out) = (row[0], row[14]);
        left += before[1] * (now - before[0]);
        before = [now, out];
    }
    // 29 of 32 rows of cells have their centres below 4.5.
    let lost = 29.0 / 32.0 * 5.0 * 2.5 * 0.1 - rows.last().unwrap()[1];
    assert!(lost > 0.0 && (left / lost - 1.0).abs() < 0.02, "{left} of {lost}");
    let [time, out] = before;
    assert!(out > 0.3 * time * 0.625 * 0.1 && out < 4.0 * time * 0.625 * 0.1, "{out} at {time}");
}

/// The steady state of a heap under a fluid, its surface held, is where marching stays: two cells a grain.
#[test]
fn a_heap_under_a_fluid_is_found_directly() {
    let case = of_catalogue("heap_flow")
        .edit("system/blockMeshDict", "(2 19 60) simple", "(1 19 60) simple")
        .edit("system/fvSchemes", "Euler", "steadyState")
        .edit("system/controlDict", "endTime         1.4;", "endTime         0.02;")
        .edit("system/controlDict", "writeInterval   0.7;", "writeInterval   0.02;")
        .remove("system/plotDict");
    let out = case.run(&["run", "-j", "1"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(said.contains("steady state: forces are out of balance by"), "{said}");
    assert!(!said.contains("not converged"), "{said}");
    let profile = |time: &str| {
        let file = format!("postProcessing/profile/{time}/centre_U_fluidity_stressRatio_alpha.csv");
        let t = granflow_case::figures::table::Table::parse(&case.read(&file));
        t.columns[t.column("U_x").unwrap()].clone()
    };
    let found = profile("0.02");
    let case = case
        .edit("system/fvSchemes", "steadyState", "Euler")
        .edit("system/controlDict", "endTime         0.02;", "endTime         0.1;")
        .edit("system/controlDict", "writeInterval   0.02;", "writeInterval   0.1;");
    let out = case.run(&["run", "-j", "1", "--from", "latest"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let file = "postProcessing/profile/0.1/centre_U_fluidity_stressRatio_alpha.csv";
    let t = granflow_case::figures::table::Table::parse(&case.read(file));
    let marched = t.columns[t.column("U_x").unwrap()].clone();
    let most = found.iter().copied().fold(0.0, f64::max);
    let apart = found.iter().zip(&marched).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("surface {most} m/s, four steps later apart by {:.1e} of it", apart / most);
    assert!(most > 0.1 && apart < 1e-5 * most, "{apart} of {most}");
}

/// Sixteen cells over 5 widths, eight over 2.5: the column covers 3 x 6 of them, and hardly moves in a step.
#[test]
fn gauges_see_how_high_water_stands() {
    let width = 0.146;
    let cell = 2.5 * width / 8.0;
    let places = [(0.5 * width, 0.1), (3.0 * cell, 0.0), (3.0 * width, 0.0)];
    let list: String = places.iter().map(|(x, y)| format!("({x} {y} 0.005)")).collect();
    for ranks in [1, 3] {
        let case = dam()
            .edit("system/controlDict", "deltaT          0.001;", "deltaT 1e-6;")
            .edit("system/controlDict", "adjustTimeStep  yes;", "adjustTimeStep no;")
            .edit("system/controlDict", "endTime         0.02;", "endTime 1e-6;")
            .edit(
                "system/controlDict",
                "functions\n{",
                &format!("functions {{ gauge {{ type interfaceHeight; locations ({list}); }}"),
            );
        let options = Options { ranks, ..Options::default() };
        let (sink, notices) = (Sink::new(), Notices::new());
        let mut run = Run::load(case.path(), &options, &sink, &notices).unwrap();
        while !matches!(run.advance().unwrap(), Event::Done(_)) {}
        let heights = case.read("postProcessing/gauge/0/height.dat");
        let row: Vec<f64> = heights
            .lines()
            .last()
            .unwrap()
            .split_whitespace()
            .map(|x| x.parse().unwrap())
            .collect();
        let full = 6.0 * cell;
        // Between a full column of cells and an empty one, half of it.
        let wanted = [full, full - 0.1, 0.5 * full, 0.5 * full, 0.0, 0.0];
        assert_eq!(row.len(), 7, "{heights}");
        for (found, wanted) in row[1..].iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-6 * full, "{ranks} ranks: {heights}");
        }
        let positions = case.read("postProcessing/gauge/0/position.dat");
        assert!(
            positions.contains("(0.073 0.27") && positions.contains("# Location 2 "),
            "{positions}"
        );
    }
    let case = dam().edit(
        "system/controlDict",
        "functions\n{",
        "functions { gauge { type interfaceHeight; locations ((9 0 0)); }",
    );
    let run = case.run(&["run"]);
    let said = text(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(said.contains("no vertical through location 0 at (9 0 0) meets the mesh"), "{said}");
}

/// The cells of a mesh that is long in x are numbered anew inside; what passes its periodic sides must find the cells behind them.
#[test]
fn water_passes_periodic_sides_of_a_renumbered_mesh() {
    let case = Case::below("compatible", "periodic");
    let edited = |file: &str, edits: &[(&str, &str)]| {
        let text = edits.iter().fold(case.read(file), |text, (from, to)| {
            assert!(text.contains(from), "{file}: {from}");
            text.replace(from, to)
        });
        case.put(file, text.as_bytes());
    };
    edited("system/blockMeshDict", &[("(10 10 1)", "(40 10 1)")]);
    edited(
        "system/controlDict",
        &[("deltaT 0.02", "deltaT 0.005"), ("writeInterval 20", "writeInterval 80")],
    );
    ran(&case, &["run", "-j", "1"]);
    let field = case.read("0.4/alpha.water");
    let (_, list) = field.split_once("internalField").unwrap();
    let (list, _) = list.split_once("boundaryField").unwrap();
    let words = list[list.find('(').unwrap() + 1..].split_whitespace();
    let alpha: Vec<f64> = words.map_while(|w| w.parse().ok()).collect();
    assert_eq!(alpha.len(), 400);
    // 12 x 4 cells and 4 half full ones. A digit of ten is lost in each.
    let water: f64 = alpha.iter().sum();
    assert!((water - 50.0).abs() < 1e-7, "{water}");
    // It has come through the side.
    assert!((0..10).any(|j| alpha[40 * j] > 0.5), "{alpha:?}");
}
