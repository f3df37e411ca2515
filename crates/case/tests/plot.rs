//! Figures as a person gets them. The pictures land in the folder that GRANFLOW_FIGURES names,
//! for looking at.

#![allow(clippy::unwrap_used)]

use granflow_case::plot::{Axis, Legend, LineFigure, Marker, Rgb, Series};

/// A curve like the velocity in an annular shear cell: exponential, then down to the outer wall.
fn reference() -> Vec<(f64, f64)> {
    let v = |s: f64| (-0.38 * s - 0.012 * s * s).exp() * (1.0 - (s / 16.0).powi(8));
    (0..160).map(|i| f64::from(i) * 0.1).map(|s| (s, v(s))).collect()
}

fn shear_cell() -> LineFigure {
    let curve = reference();
    let mut series = vec![Series::line("reference", curve.clone()).coloured(Rgb::BLACK)];
    let speeds = ["10^{-4}", "10^{-3}", "10^{-2}", "10^{-1}"];
    for (k, name) in speeds.iter().enumerate() {
        let spread = 1.0 + 0.03 * (k as f64 - 1.5);
        let points = curve.iter().skip(2 * k).step_by(9).map(|(s, v)| (*s, v.powf(spread)));
        let name = format!("ΩR_i = {name} m/s");
        series.push(Series::markers(name, Marker::nth(k), points.collect()));
    }
    LineFigure {
        title: String::new(),
        x: Axis::linear("(r − R_i)/d"),
        y: Axis::log("V_θ/V_{wall}"),
        series,
        legend: Legend::Auto,
    }
}

fn show(name: &str, figure: &LineFigure) -> (String, Vec<u8>) {
    let (svg, png) = (figure.to_svg(), figure.to_png().unwrap());
    if let Ok(folder) = std::env::var("GRANFLOW_FIGURES") {
        let path = std::path::Path::new(&folder);
        std::fs::create_dir_all(path).unwrap();
        std::fs::write(path.join(format!("{name}.svg")), &svg).unwrap();
        std::fs::write(path.join(format!("{name}.png")), &png).unwrap();
    }
    (svg, png)
}

fn png_size(png: &[u8]) -> (u32, u32) {
    let word = |i: usize| u32::from_be_bytes(png[i..i + 4].try_into().unwrap());
    (word(16), word(20))
}

#[test]
fn the_shear_cell() {
    let (svg, png) = show("shear_cell", &shear_cell());
    assert_eq!(png_size(&png), (1600, 1120));
    assert!(svg.contains("viewBox=\"0 0 800 560\""));
    assert_eq!(svg.matches("<svg").count(), 1);
    for text in [">reference<", ">wall<", ">(r − R<"] {
        assert!(svg.contains(text), "{text} is missing");
    }
    // Decades only.
    assert!(svg.contains(">−4<") && !svg.contains(">0.5<"));
}

#[test]
fn linear_axes_dashes_factors_and_a_title() {
    let wave = |phase: f64| {
        let x = (0..400).map(|i| f64::from(i) * 1e-7);
        x.map(|x| (x, 3e5 * (2e5 * x + phase).sin())).collect::<Vec<_>>()
    };
    let figure = LineFigure {
        title: "Pressure at the probe, σ = 0.072 N m^{-1}".to_owned(),
        x: Axis::linear("t in s"),
        y: Axis::linear("p in Pa"),
        series: vec![
            Series::line("U, 3 threads", wave(0.0)),
            Series::dashed("p_{rgh}", wave(1.0)),
            Series::markers("exact", Marker::Cross, wave(2.0).into_iter().step_by(20).collect()),
        ],
        legend: Legend::Auto,
    };
    let (svg, _) = show("waves", &figure);
    assert!(svg.contains(">×10<") && svg.contains(">−5<"));
}

#[test]
fn residuals_with_gaps_and_many_points() {
    let noise = |k: f64| move |i: u32| ((f64::from(i) * 12.9898 + k).sin() * 43758.5453).fract();
    let line = |name: &str, k: f64| {
        let decay = |i: u32| 10f64.powf(-f64::from(i) / 9000.0 * (1.0 + k) + 0.3 * noise(k)(i));
        Series::line(name, (0..60_000).map(|i| (f64::from(i), decay(i))).collect())
    };
    let mut gaps = line("fluidity", 0.6);
    for p in gaps.points.iter_mut().filter(|p| (20_000.0..30_000.0).contains(&p.0)) {
        p.1 = if p.0 < 25_000.0 { 0.0 } else { f64::NAN };
    }
    let figure = LineFigure {
        x: Axis::linear("iteration"),
        y: Axis::log("residual"),
        series: vec![line("U", 0.0), line("p", 0.3), gaps],
        ..LineFigure::default()
    };
    let (svg, png) = show("residuals", &figure);
    assert!(svg.len() < 6_000_000 && png.len() < 1_000_000, "{} {}", svg.len(), png.len());
}

#[test]
fn a_legend_that_finds_no_corner_goes_outside() {
    let full: Vec<_> = (0..2000).map(|i| (f64::from(i), (f64::from(i) * 0.2).sin())).collect();
    let mut figure =
        LineFigure { series: vec![Series::line("everywhere", full)], ..LineFigure::default() };
    let (inside, _) = show("outside", &figure);
    figure.legend = Legend::None;
    assert!(inside.contains(">everywhere<"));
    assert!(!figure.to_svg().contains(">everywhere<"));
}

#[test]
fn nothing_to_draw_is_still_a_figure() {
    show("empty", &LineFigure::default());
    let odd = LineFigure {
        title: "a < b & \"c\" $5 for $6".to_owned(),
        x: Axis::log("x").ranged(f64::NAN, -1.0),
        y: Axis::linear("y").ranged(1.0, 1.0),
        series: vec![
            Series::line("one", vec![(1.0, 2.0)]),
            Series::line("none", vec![]),
            Series::markers("bad", Marker::Plus, vec![(f64::NAN, 1.0), (-1.0, f64::INFINITY)]),
            Series::line("huge", vec![(1.0, -f64::MAX), (2.0, f64::MAX)]),
        ],
        legend: Legend::Outside,
    };
    let (svg, _) = show("odd", &odd);
    assert!(svg.contains("a &lt; b &amp; &quot;c&quot; $5 for $6"));
    assert!(odd.to_png_scaled(0.0).is_err() && odd.to_png_scaled(f64::NAN).is_err());
}

#[test]
fn a_given_range_cuts_lines_and_drops_markers() {
    let line: Vec<_> = (0..=100).map(|i| (f64::from(i), f64::from(i))).collect();
    let figure = LineFigure {
        title: String::new(),
        x: Axis::linear("x").ranged(20.0, 60.0),
        y: Axis::linear("y").ranged(0.0, 50.0),
        series: vec![
            Series::line("line", line.clone()),
            Series::markers("circles", Marker::Circle, line),
        ],
        legend: Legend::None,
    };
    let (svg, _) = show("cut", &figure);
    assert_eq!(svg.matches("<circle").count(), 31);
}
