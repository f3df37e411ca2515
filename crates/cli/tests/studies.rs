//! `granflow sweep` and `granflow fit` as a user calls them.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a test may fail, and prints")]

mod common;

use common::{Case, of_catalogue, text};
use granflow_case::figures::table::Table;

fn table(case: &Case, file: &str) -> Table {
    Table::parse(&case.read(file))
}
fn column(t: &Table, name: &str) -> Vec<f64> {
    t.columns[t.column(name).unwrap_or_else(|| panic!("{name} in {:?}", t.names))].clone()
}

/// The friction of the annular cell's wall rises with its speed; every point is a steady state, and a case that can
/// be looked at.
#[test]
fn a_sweep_walks_five_decades_of_speed() {
    let case = of_catalogue("annular_shear_cell");
    let out = case.run(&["sweep", "-j", "1"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let t = table(&case, "sweep/wallSpeed.csv");
    let (v, mu) = (column(&t, "wallSpeed"), column(&t, "muWall"));
    println!("{v:?}\n{mu:?}");
    assert_eq!((v.len(), v[0], v[10]), (11, 1e-6, 0.1));
    assert!(mu.windows(2).all(|w| w[0] < w[1]), "{mu:?}");
    // At 1e-5 m/s nearly the quasi-static limit, mu_s.
    assert!(mu[0] > 0.3819 && mu[0] < 0.385, "{mu:?}");
    assert!(column(&t, "steady").iter().all(|s| *s == 1.0));
    for file in ["postProcessing/figures/sweep_muWall.png", "sweep/wallSpeed_0.001/1/U"] {
        assert!(case.path().join(file).is_file(), "{file}");
    }
    // The case itself is as it was.
    assert!(!case.path().join("1").exists());
}

/// The primitive form's branch of flowing layers ends at h_stop = (pi/2) A d sqrt((mu_2 - mu)/(dmu (mu - mu_s))).
#[test]
fn a_family_of_sweeps_follows_the_branch_to_h_stop() {
    let case = of_catalogue("incline");
    let out = case.run(&["sweep", "-j", "2"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let t = table(&case, "sweep/limit.csv");
    let (angle, limit) = (column(&t, "angle"), column(&t, "limit"));
    for (degrees, h) in angle.iter().zip(&limit) {
        let mu = degrees.to_radians().tan();
        let exact = std::f64::consts::FRAC_PI_2
            * 0.48
            * ((0.6435 - mu) / ((0.6435 - 0.3819) * (mu - 0.3819))).sqrt();
        println!("{degrees} degrees: h_stop {h} d, exactly {exact}");
        assert!((h / exact - 1.0).abs() < 0.01, "{degrees}: {h} {exact}");
    }
    assert_eq!(angle, [22.0, 24.0, 26.0, 28.0, 30.0]);
    assert!(said.contains("angle 24: the flow ends between thickness"), "{said}");
}

/// The primitive form's yield depends on size: what narrow chutes need. Threshold of the linear stability of rest,
/// `A^2 d^2 g'' + dmu (mu - mu_s)/(mu_2 - mu) g = 0` with zero gradient at walls and centre, by shooting.
#[test]
fn narrow_chutes_need_more_friction() {
    let case = of_catalogue("vertical_chute").edit(
        "system/sweepDict",
        "values      (5 7 10 15 20 30 40);",
        "values      (10 20);",
    );
    let out = case.run(&["sweep", "-j", "2"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let t = table(&case, "sweep/limit.csv");
    for ((width, limit), exact) in
        column(&t, "width").iter().zip(column(&t, "limit")).zip([0.490536, 0.452379])
    {
        println!("{width} d: {limit}, exactly {exact}");
        assert!((limit - exact).abs() < 1e-4, "{width}: {limit} {exact}");
    }
}

/// Independent points, two at a time, are what they are one by one.
#[test]
fn points_side_by_side_are_the_same() {
    let run = |threads: &str| {
        let case = of_catalogue("annular_shear_cell")
            .edit("system/sweepDict", "continuation    yes;", "continuation    no;")
            .edit("system/sweepDict", "points 11;", "points 3;");
        let out = case.run(&["sweep", "-j", threads]);
        assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
        case.read("sweep/wallSpeed.csv")
    };
    assert_eq!(run("1"), run("2"));
}

/// Where no steady flow exists a point says so, and the others are there.
#[test]
fn a_point_without_a_solution_is_told() {
    let case = of_catalogue("vertical_chute").write(
        "system/sweepDict",
        "parameter pull; values (20 39.4996708361 80);
         set ( { file constant/g; entry value; value \"({x} 0 0)\"; } );
         results ( { name u; file \"postProcessing/profile/<time>/height_U_fluidity_stressRatio.csv\";
                     value \"max(U_x)\"; } );",
    );
    let out = case.run(&["sweep", "-j", "1"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let t = table(&case, "sweep/pull.csv");
    assert_eq!(column(&t, "converged"), [1.0, 1.0, 0.0], "{said}");
    assert!(said.contains("no solution") && said.contains("friction of the grains"), "{said}");
}

/// A value that the case refuses is a point without a solution: the others, and the table, are there. Where every value
/// is refused the mistakes are the study's.
#[test]
fn a_point_with_mistakes_does_not_end_the_sweep() {
    let sweep = |values: &str| {
        let case = of_catalogue("annular_shear_cell").write(
            "system/sweepDict",
            &format!(
                "parameter mus; values ({values});
                 set ( {{ file constant/transportProperties; entry NGFCoeffs.mus; }} );
                 results ( {{ name M; file postProcessing/torque/0/moment.dat; value total_z; }} );"
            ),
        );
        let out = case.run(&["sweep", "-j", "1"]);
        (case, out)
    };
    let (case, out) = sweep("0.3 0.7 0.4");
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert_eq!(column(&table(&case, "sweep/mus.csv"), "converged"), [1.0, 1.0, 0.0], "{said}");
    assert!(said.contains("no solution") && said.contains("mus 0.7: "), "{said}");
    // Once more: what was there is kept.
    let again = case.run(&["sweep", "-j", "1"]);
    assert!(text(&again.stdout).contains("superseded/sweep_1"), "{}", text(&again.stdout));
    assert!(case.path().join("superseded/sweep_1/mus.csv").is_file());
    let (_, out) = sweep("0.7 0.8");
    assert_eq!(out.status.code(), Some(2), "{}", text(&out.stdout));
    assert!(text(&out.stderr).contains("transportProperties"), "{}", text(&out.stderr));
}

/// A parameter that changes nothing is told so, and the other is found.
#[test]
fn a_parameter_without_effect_is_told() {
    let case = of_catalogue("annular_shear_cell")
        .edit("system/controlDict", "endTime         5;", "endTime         1;")
        .write("measured/torque.csv", "t,M\n1,-1.35e-5\n1,-1.351e-5\n1,-1.352e-5\n")
        .write(
            "system/fitDict",
            "parameters
             (
                 { name mus; start 0.38; range (0.3 0.5);
                   set ( { file constant/transportProperties; entry NGFCoeffs.mus; } ); }
                 { name nothing; start 1; range (0 2);
                   set ( { file system/controlDict; entry nothing; } ); }
             );
             data ( { name torque; measured measured/torque.csv; x t; y M;
                      file postProcessing/torque/0/moment.dat; modelX Time; modelY total_z; } );",
        );
    let out = case.run(&["fit", "-j", "2"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(said.contains("nothing    1 the data do not tell it"), "{said}");
    let csv = case.read("fit/parameters.csv");
    assert!(csv.lines().any(|l| l.starts_with("nothing,1,nan")), "{csv}");
    assert!(text(&out.stderr).contains("unused entry `nothing`"), "{}", text(&out.stderr));
}

#[test]
fn mistakes_of_a_sweep_are_said_with_their_place() {
    let case = of_catalogue("annular_shear_cell")
        .edit("system/sweepDict", "parameter ", "parametr ")
        .edit("system/sweepDict", "{x/0.051}", "{z/0.051}");
    let out = case.run(&["sweep"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(2), "{said}");
    for word in ["system/sweepDict:", "`parametr`", "`z`", "3 errors", "nothing was changed"] {
        assert!(said.contains(word), "{word}: {said}");
    }
    let case = of_catalogue("annular_shear_cell").edit("system/sweepDict", "0.orig/U", "0.orig/V");
    let out = case.run(&["sweep"]);
    assert_eq!(out.status.code(), Some(2));
    assert!(text(&out.stderr).contains("no file `0.orig/V`"), "{}", text(&out.stderr));
}

/// A sequence of numbers like those of a normal distribution: P. L'Ecuyer's generator and the sum of twelve.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 12_345_u64;
    let mut uniform = move || {
        state = state * 40_692 % 2_147_483_399;
        state as f64 / 2_147_483_399.0
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// Profile and torque of the annular cell with known parameters and 2 % of noise: the fit recovers them within its
/// intervals, which are no wider than the noise allows.
#[test]
fn a_fit_recovers_the_parameters_behind_noisy_data() {
    let (file, moment) = (
        "postProcessing/profile/1/radius_U_fluidity_stressRatio.csv",
        "postProcessing/torque/0/moment.dat",
    );
    let measured = of_catalogue("annular_shear_cell");
    let truth = [("mus", 0.3819), ("A", 0.48)];
    let run = measured.run(&["run", "-j", "1", "--until", "1"]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
    let profile = table(&measured, file);
    let (r, v) = (column(&profile, "x"), column(&profile, "U_y"));
    let mut random = noise();
    let mut rows = String::from("r,V,error\n");
    for i in (2..60).step_by(3) {
        let error = 0.02 * v[i];
        rows += &format!("{},{},{error}\n", r[i], v[i] + error * random());
    }
    let torque = *column(&table(&measured, moment), "total_z").last().unwrap();
    let error = 0.005 * torque.abs();
    let one = format!("t,M,error\n1,{},{error}\n", torque + error * random());
    let two = format!("{one}1,{},{error}\n", torque + error * random());

    let case = of_catalogue("annular_shear_cell")
        .edit("system/controlDict", "endTime         5;", "endTime         1;")
        .write("measured/profile.csv", &rows)
        .write("measured/torque.csv", &two)
        .write(
            "system/fitDict",
            "parameters
             (
                 { name mus; start 0.36; range (0.3 0.5);
                   set ( { file constant/transportProperties; entry NGFCoeffs.mus; } ); }
                 { name A; start 0.7; range (0.1 2);
                   set ( { file constant/transportProperties; entry NGFCoeffs.A; } ); }
             );
             data
             (
                 { name profile; measured measured/profile.csv; x r; y V; error error;
                   file \"postProcessing/profile/<time>/radius_U_fluidity_stressRatio.csv\";
                   modelX x; modelY U_y; scale logarithmic; }
                 { name torque; measured measured/torque.csv; x t; y M; error error;
                   file postProcessing/torque/0/moment.dat; modelX Time; modelY total_z; }
             );",
        );
    let out = case.run(&["fit", "-j", "2"]);
    let said = text(&out.stdout);
    println!("{said}");
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let csv = case.read("fit/parameters.csv");
    for ((name, exact), row) in truth.iter().zip(csv.lines().skip(1)) {
        let words: Vec<&str> = row.split(',').collect();
        let [value, half] = [1, 2].map(|i| words[i].parse::<f64>().unwrap());
        assert_eq!(words[0], *name);
        assert!((value - exact).abs() < half, "{name}: {value} +- {half}, behind it {exact}");
        // 20 values of 2 % tell an amplitude to about 1 %, and the torque mu_s to 0.5 %.
        assert!(half < 0.05 * exact, "{name}: {value} +- {half}");
    }
    for file in ["postProcessing/figures/fit_profile.png", "postProcessing/figures/fit_profile.svg"]
    {
        assert!(case.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn a_fit_says_what_it_lacks() {
    let case = of_catalogue("annular_shear_cell").write(
        "system/fitDict",
        "parameters ( { name mus; start 0.9; range (0.3 0.5); set ( { file f; entry e; } ); } );
         data ( { name d; measured measured/none.csv; x r; y V; file f; modelX x; modelY y; } );",
    );
    let out = case.run(&["fit"]);
    let said = text(&out.stderr);
    assert_eq!(out.status.code(), Some(2), "{said}");
    for word in [
        "start 0.9 does not lie in the range 0.3 to 0.5",
        "measured/none.csv",
        "nothing was changed",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
}
