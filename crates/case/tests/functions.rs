//! Functions against flows with known solutions.
#![allow(clippy::unwrap_used)]

mod common;
use common::*;
use granflow_case::figures::table::Table;

#[test]
fn profiles_of_couette_flow_are_straight() {
    let dir = couette(
        "s { type sets; fields (U strainRate); interpolationScheme cellPoint; sets (
            even { type uniform; axis y; start (0.15 0 0.05); end (0.15 0.2 0.05); nPoints 9; }
            mid { type midPoint; axis distance; start (0.15 0 0.05); end (0.15 0.2 0.05); }
            ends { type face; axis xyz; start (0.15 0 0.05); end (0.15 0.2 0.05); } ); }
         c { type profile; setFormat csv; fields (U); start (0.1 0 0.05); end (0.1 0.2 0.05); }",
    );
    run(dir.path(), &until(3000.0));
    let table = |f: &str| Table::parse(&read(dir.path(), &format!("postProcessing/{f}")));
    for (file, rows, axis) in [
        ("s/3000/even_U_strainRate.xy", 9, "y"),
        ("s/3000/mid_U_strainRate.xy", 8, "distance"),
        ("s/3000/ends_U_strainRate.xy", 9, "y"),
        ("c/3000/c_U.csv", 8, "distance"),
    ] {
        let t = table(file);
        let column = |name: &str| &t.columns[t.column(name).unwrap()];
        assert_eq!(column(axis).len(), rows, "{file}");
        for (y, u) in column(axis).iter().zip(column("U_x")) {
            assert!((u - y / H).abs() < 1e-9, "{file}: U({y}) = {u}");
        }
        if t.column("strainRate").is_some() {
            assert!(column("strainRate").iter().all(|g| (g - 1.0 / H).abs() < 1e-8), "{file}");
        }
    }
}

#[test]
fn forces_of_couette_flow_are_exact_and_balance() {
    let dir = couette(
        "top { type forces; patches (yMax); CofR (0.15 0 0.05); }
         all { type forces; patches (yMax yMin); }
         extremes { type fieldMinMax; fields (U); }
         residuals { type residuals; }",
    );
    run(dir.path(), &until(3000.0));
    let last = |f: &str| {
        let t = Table::parse(&read(dir.path(), &format!("postProcessing/{f}")));
        t.columns.iter().map(|c| *c.last().unwrap()).collect::<Vec<f64>>()
    };
    // eta/h times the area 0.3 x 0.1: the flow holds the lid back.
    let drag = 0.02 * 50.0 / H * 0.03;
    let top = last("top/0/force.dat");
    assert!((top[1] + drag).abs() < 1e-9 * drag, "{top:?} {drag}");
    assert!((top[7] + drag).abs() < 1e-9 * drag, "viscous: {top:?}");
    // The moment about a point one gap below the lid: F h about -z... (r x F)_z = -y F_x.
    let moment = last("top/0/moment.dat");
    assert!((moment[3] - H * drag).abs() < 1e-9 * drag, "{moment:?}");
    let all = last("all/0/force.dat");
    assert!(all[1].abs() < 1e-9 * drag, "{all:?}");
    // Of cells and walls: it stands at the bottom and moves with the lid.
    let text = read(dir.path(), "postProcessing/extremes/0/fieldMinMax.dat");
    let line: Vec<&str> = text.lines().last().unwrap().split('\t').map(str::trim).collect();
    assert_eq!(line[..2], ["3000", "mag(U)"]);
    let (least, most): (f64, f64) = (line[2].parse().unwrap(), line[4].parse().unwrap());
    assert!(least == 0.0 && most == 1.0, "{text}");
    assert!(line[3].contains(" 0 ") && line[5].contains(" 0.2 "), "{text}");
    assert_eq!(last("residuals/0/residuals.dat")[0], 3000.0);
}

/// U = y/h on eight rows of faces 0.1 m x h/8; the flow goes along `yMax` and comes through `xMin`.
#[test]
fn patches_are_summed_and_averaged() {
    let function = |name: &str, patch: &str, operation: &str, fields: &str| {
        format!(
            "{name} {{ type surfaceFieldValue; writeFields no; regionType patch; name {patch};
             operation {operation}; fields ({fields}); }}"
        )
    };
    let all = [
        function("lid", "yMax", "areaAverage", "U p"),
        function("drag", "yMax", "areaIntegrate", "U"),
        function("leak", "yMax", "sumMag", "phi"),
        function("most", "yMax", "max", "U"),
    ];
    let dir = couette(&all.join("\n"));
    run(dir.path(), &until(3000.0));
    let last = |name: &str| {
        let path = format!("postProcessing/{name}/0/surfaceFieldValue.dat");
        let text = read(dir.path(), &path);
        let row = text.lines().last().unwrap();
        row.split(['\t', ' ', '(', ')']).filter_map(|w| w.parse().ok()).collect::<Vec<f64>>()
    };
    let near = |found: &[f64], wanted: &[f64]| {
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        let apart = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
        assert!(found.iter().zip(wanted).all(apart), "{found:?}");
    };
    near(&last("lid"), &[3000.0, 1.0, 0.0, 0.0, 0.0]);
    near(&last("drag"), &[3000.0, 0.03, 0.0, 0.0]);
    near(&last("leak"), &[3000.0, 0.0]);
    near(&last("most"), &[3000.0, 1.0, 0.0, 0.0]);
}

#[test]
fn figures_are_drawn_from_what_functions_wrote() {
    let dir = couette("c { type profile; fields (U); start (0.1 0 0.05); end (0.1 0.2 0.05); }");
    put(dir.path(), "reference.csv", "# exact\ny,u\n0,0\n0.2,1\n");
    put(
        dir.path(),
        "system/plotDict",
        "figures { velocity { title \"Couette\"; xLabel \"y/h\"; yLabel \"U/U_{lid}\"; curves (
            { file \"postProcessing/c/<time>/c_U.xy\"; time all; label \"t = <time> s\";
              x \"distance/0.2\"; y \"U_x/max(U_x)\"; }
            { reference \"reference.csv\"; label exact; x \"y/0.2\"; y u; } ); } }",
    );
    let mut run = run(dir.path(), &until(3000.0));
    let sink = granflow_dict::Sink::new();
    let made = run.finish(&sink).unwrap();
    assert!(sink.take().is_empty());
    assert_eq!(made.len(), 2);
    let svg = read(dir.path(), "postProcessing/figures/velocity.svg");
    assert!(svg.contains("t = 3000 s") && svg.contains("exact"), "{svg}");
    assert!(made.iter().all(|f| f.is_file()));
    let typo = "figures { v { curves ( { file reference.csv; x yy; y u; } ); colour red; } }";
    put(dir.path(), "system/plotDict", typo);
    assert!(granflow_case::figures::draw(dir.path(), &sink).is_err());
    let said = sink.take().to_string();
    assert!(said.contains("no column `yy`; the columns are y, u"), "{said}");
    assert!(said.contains("unknown entry `colour`"), "{said}");
}
