//! `index.html`: the steps of a remeshing in order.

use super::figures::{MeshChange, RemeshFigures};
use super::panels::{PanelScale, PicturePanel};
use crate::output::report::{STYLE, escape, format_tick, quantity, ratio};
use crate::scene::{RemeshMethod, Scene};

/// Returns the file name of a picture.
pub(super) fn picture_file(number: usize, name: &str, view: &str) -> String {
    format!("{number:02}-{name}-{view}.png")
}

/// Returns the page as HTML.
pub(super) fn page(scene: &Scene, panels: &[PicturePanel], figures: &RemeshFigures) -> String {
    let (name, title) = (escape(&scene.scene.name), escape(&scene.scene.title));
    let sections: String = panels.iter().zip(1..).map(|(panel, number)| section(panel, number)).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{name}: remeshing — ballistic-gel</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <header><h1>{name}: remeshing</h1>\n<p class=\"title\">{title}</p></header>\n\
         <p class=\"lead\">At {} a mesh of {} elements is replaced; its least element quality is {}. Left: the whole \
         gel. Right: the surroundings of that element.</p>\n{sections}{}</main>\n</body>\n</html>\n",
        quantity(figures.time, "s"),
        figures.elements,
        ratio(figures.least_quality),
        table(figures)
    )
}

fn section(panel: &PicturePanel, number: usize) -> String {
    let picture = |view: &str| {
        format!(
            "<img alt=\"{}, {view}\" src=\"{}\" width=\"720\" height=\"720\"/>",
            panel.text.title,
            picture_file(number, panel.text.name, view)
        )
    };
    format!(
        "<section><h2>{number}. {}</h2>\n<p>{}</p>\n{}<div class=\"pair\">{}{}</div></section>\n",
        panel.text.title,
        panel.text.about,
        panel.scale.as_ref().map(legend).unwrap_or_default(),
        picture("whole"),
        picture("close")
    )
}

fn legend(scale: &PanelScale) -> String {
    let PanelScale { low, high, unit, map } = *scale;
    let ticks: String = [0.0, 0.25, 0.5, 0.75, 1.0]
        .map(|place| format!("<span>{}</span>", format_tick(low + place * (high - low), high, unit)))
        .concat();
    format!(
        "<div class=\"bar\" style=\"background: linear-gradient(to right, {})\"></div>\n<div class=\"ticks\">{ticks}</div>\n",
        map.css()
    )
}

/// Row of the table of figures: caption and formatter.
type FigureRow = (&'static str, fn(&MeshChange) -> String);
const ROWS: [FigureRow; 10] = [
    ("Elements", |c| c.elements.to_string()),
    ("Least quality", |c| ratio(c.least_quality)),
    ("Least angle", |c| format!("{:.1}°", c.least_angle)),
    ("Change of area", |c| ratio(c.area)),
    ("Mass covered by no new element or by two", |c| ratio(c.mass)),
    ("Momentum error before correction", |c| ratio(c.momentum)),
    ("Change of kinetic energy", |c| ratio(c.kinetic)),
    ("Change of stored energy", |c| ratio(c.stored)),
    ("Unchanged elements", |c| ratio(c.unchanged)),
    ("Attempt", |c| c.attempt.to_string()),
];

/// Returns the table with the figures of both methods side by side.
fn table(figures: &RemeshFigures) -> String {
    let named = |method: RemeshMethod| match method {
        RemeshMethod::Local => "local",
        RemeshMethod::Immersed => "immersed",
    };
    let head: Vec<String> = figures.methods.iter().map(|o| format!("<th>{}</th>", named(o.method))).collect();
    let refused =
        figures.methods.iter().filter_map(|outcome| outcome.refused.as_ref().map(|why| (outcome.method, why)));
    let refused: Vec<String> =
        refused.map(|(method, why)| format!("<p>No {} mesh: {}.</p>\n", named(method), escape(why))).collect();
    let cells = |value: fn(&MeshChange) -> String| -> String {
        let cell = |change: Option<&MeshChange>| format!("<td>{}</td>", change.map_or_else(|| "–".to_owned(), value));
        figures.methods.iter().map(|outcome| cell(outcome.mesh.as_ref())).collect()
    };
    let rows: Vec<String> =
        ROWS.iter().map(|(name, value)| format!("<tr><th>{name}</th>{}</tr>\n", cells(*value))).collect();
    format!(
        "<section><h2>Figures</h2>\n<p>Changes relative to the old mesh.</p>\n{}<div class=\"wide\"><table>\n\
         <thead><tr><th></th>{}</tr></thead>\n<tbody>\n{}</tbody></table></div></section>\n",
        refused.concat(),
        head.concat(),
        rows.concat()
    )
}
