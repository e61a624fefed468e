//! Legends of drawings and plots, whose signs are drawn: they are printed also without backgrounds.

/// Sign of a legend with its name.
pub(super) struct LegendEntry {
    /// SVG elements in a box of 28 by 12.
    sign: String,
    name: String,
}

impl LegendEntry {
    /// Entry of an area with the style of a class.
    pub(super) fn area(class: &str, name: impl Into<String>) -> Self {
        Self { sign: format!("<rect class=\"{class}\" width=\"28\" height=\"10\" y=\"1\"/>"), name: name.into() }
    }

    /// Entry of a line with the style of a class.
    pub(super) fn line(class: &str, name: impl Into<String>) -> Self {
        Self { sign: format!("<path class=\"{class}\" d=\"M0,6H28\"/>"), name: name.into() }
    }

    /// Entry of a curve of a colour and a dash pattern.
    pub(super) fn curve(colour: &str, dashes: &str, name: impl Into<String>) -> Self {
        let sign = format!(
            "<path d=\"M0,6H28\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.5\" stroke-dasharray=\"{dashes}\"/>"
        );
        Self { sign, name: name.into() }
    }

    /// Entry of measured points of a colour.
    pub(super) fn dots(colour: &str, name: impl Into<String>) -> Self {
        let dot = |x: u32| format!("<circle cx=\"{x}\" cy=\"6\" r=\"4\" fill=\"{colour}\"/>");
        Self { sign: dot(6) + &dot(20), name: name.into() }
    }
}

/// Returns a legend as HTML; names are HTML, too.
pub(super) fn legend(entries: &[LegendEntry]) -> String {
    let entry = |LegendEntry { sign, name }: &LegendEntry| {
        format!(
            "<li><svg class=\"sign\" viewBox=\"0 0 28 12\" width=\"28\" height=\"12\" aria-hidden=\"true\" \
             xmlns=\"http://www.w3.org/2000/svg\">{sign}</svg>{name}</li>"
        )
    };
    format!("<ul class=\"key\">{}</ul>\n", entries.iter().map(entry).collect::<String>())
}
