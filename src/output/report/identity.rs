//! Head of the report: case, author, logo and date, as far as they are given, and the title of the shot.

use super::format::escape;
use crate::scene::{Dimension, Scene};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;
use std::time::{SystemTime, UNIX_EPOCH};

/// Limit of the size of a logo, bytes: it is embedded in the page.
pub const MOST_LOGO_BYTES: u64 = 1 << 20;

/// Case, author, logo and date of a report; what is absent is not shown.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ReportIdentity {
    /// Case, such as the number of a file.
    pub case: Option<String>,
    /// Author of the report.
    pub author: Option<String>,
    /// Logo of the laboratory.
    pub logo: Option<LogoImage>,
    /// Date of the report.
    pub date: Option<ReportDate>,
}

/// Image of a logo: PNG, JPEG or SVG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogoImage {
    media_type: &'static str,
    bytes: Vec<u8>,
}

impl LogoImage {
    /// Takes the content of an image file; an SVG has to be well-formed.
    ///
    /// # Errors
    /// The content found instead of an image.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, String> {
        let media_type = match &bytes[..] {
            [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a, ..] => "image/png",
            [0xff, 0xd8, 0xff, ..] => "image/jpeg",
            [] => return Err("an empty file".to_owned()),
            other => match std::str::from_utf8(other) {
                Ok(text) => svg_type(text)?,
                Err(_) => return Err("a file of another kind".to_owned()),
            },
        };
        Ok(Self { media_type, bytes })
    }

    /// Returns the image as an element of the page. A browser runs no script of an image and loads nothing for it.
    fn html(&self) -> String {
        format!(
            "<img class=\"logo\" alt=\"Logo\" src=\"data:{};base64,{}\"/>\n",
            self.media_type,
            STANDARD.encode(&self.bytes)
        )
    }
}

/// Returns the media type of an SVG text.
fn svg_type(text: &str) -> Result<&'static str, String> {
    use quick_xml::events::Event;
    let mut reader = quick_xml::Reader::from_str(text.trim_start_matches('\u{feff}'));
    let (mut is_svg, mut depth) = (false, 0usize);
    loop {
        match reader.read_event().map_err(|error| format!("a text that is no SVG ({error})"))? {
            Event::Start(tag) | Event::Empty(tag) if depth == 0 && !is_svg => {
                is_svg = tag.local_name().as_ref() == "svg";
                if !is_svg {
                    return Err("a text that is no SVG".to_owned());
                }
                depth += 1;
            }
            Event::Eof if is_svg => return Ok("image/svg+xml"),
            Event::Eof => return Err("a text that is no SVG".to_owned()),
            _ => {}
        }
    }
}

/// Calendar date, UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReportDate {
    year: i64,
    month: usize,
    day: i64,
}

impl ReportDate {
    /// Returns the date of the clock of the system.
    #[must_use]
    pub fn today() -> Self {
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
        Self::of_day(i64::try_from(seconds / 86_400).unwrap_or(0))
    }

    /// Returns the Gregorian date of a day counted from 1 January 1970 (Howard Hinnant, `civil_from_days`).
    fn of_day(day: i64) -> Self {
        let shifted = day + 719_468;
        let (era, of_era) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
        let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
        let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let from_march = (5 * of_year + 2) / 153;
        let day = of_year - (153 * from_march + 2) / 5 + 1;
        let month = usize::try_from((from_march + 2) % 12).unwrap_or(0);
        Self { year: year_of_era + 400 * era + i64::from(month < 2), month, day }
    }

    /// Returns the date in words: "1 December 2026".
    fn text(self) -> String {
        const MONTHS: [&str; 12] = [
            "January",
            "February",
            "March",
            "April",
            "May",
            "June",
            "July",
            "August",
            "September",
            "October",
            "November",
            "December",
        ];
        format!("{} {} {}", self.day, MONTHS[self.month], self.year)
    }
}

impl ReportIdentity {
    /// Returns the head of the page with its headline, a text, and what stands below it, HTML.
    pub(super) fn header(&self, headline: &str, below: &str) -> String {
        format!(
            "<header>\n{}<h1>{}</h1>\n<p class=\"title\">{below}</p></header>\n",
            self.letterhead(),
            escape(headline)
        )
    }

    /// Returns logo, case, author and date; empty if none is given.
    fn letterhead(&self) -> String {
        let mut rows = String::new();
        for (name, text) in self.entries() {
            write!(rows, "<div><dt>{name}</dt><dd>{}</dd></div>", escape(&text)).expect("a string grows");
        }
        let logo = self.logo.as_ref().map_or(String::new(), LogoImage::html);
        if rows.is_empty() && logo.is_empty() {
            return String::new();
        }
        format!("<div class=\"letterhead\">{logo}<dl class=\"identity\">{rows}</dl></div>\n")
    }

    fn entries(&self) -> Vec<(&'static str, String)> {
        let given = |text: &Option<String>| text.as_ref().filter(|text| !text.trim().is_empty()).cloned();
        let date = self.date.map(ReportDate::text);
        let all = [("Case", given(&self.case)), ("Author", given(&self.author)), ("Date", date)];
        all.into_iter().filter_map(|(name, text)| Some((name, text?))).collect()
    }

    /// Returns the style of the printed page: headline, case, author and date at its foot, beside the number of the page.
    pub(super) fn print_style(&self, headline: &str) -> String {
        let entries = self.entries().into_iter().map(|(name, text)| match name {
            "Case" => format!("case {text}"),
            _ => text,
        });
        let foot: Vec<String> = std::iter::once(headline.to_owned()).chain(entries).collect();
        format!(
            "@page {{ @bottom-left {{ content: \"{}\"; }} @bottom-right {{ content: \"page \" counter(page) \" of \" \
             counter(pages); }} }}\n",
            css_text(&foot.join(" · "))
        )
    }
}

/// Returns the line below the headline of a run.
pub(super) fn run_line(scene: &Scene, level: &str) -> String {
    let name = escape(&scene.scene.name);
    let kind = match scene.scene.dimension {
        Dimension::Planar => "in the plane",
        Dimension::Axisymmetric => "about an axis",
        Dimension::Spatial => "in space",
    };
    format!("Simulation <code>{name}</code>, {kind}, at the level <code>{level}</code>")
}

/// Returns the title of a scene, or its name if it has none.
pub(super) fn headline(scene: &Scene) -> &str {
    let title = scene.scene.title.trim();
    if title.is_empty() { &scene.scene.name } else { title }
}

/// Returns a text as the content of a CSS string, without reserved characters of CSS and XML.
fn css_text(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || " .,:;-+()/°·×".contains(c);
    // The space after an escape is part of it.
    let escaped = |c: char| if is_plain(c) { c.to_string() } else { format!("\\{:06x} ", u32::from(c)) };
    text.chars().filter(|c| !c.is_control()).map(escaped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logo_is_known_by_its_content_and_another_file_is_told() {
        let kind = |bytes: &[u8]| LogoImage::from_bytes(bytes.to_vec()).map(|logo| logo.media_type);
        assert_eq!(kind(b"\x89PNG\r\n\x1a\nrest"), Ok("image/png"));
        assert_eq!(kind(b"\xff\xd8\xff\xe0"), Ok("image/jpeg"));
        let svg = "\u{feff}<?xml version=\"1.0\"?><!-- a --><svg xmlns=\"http://www.w3.org/2000/svg\"><path/></svg>";
        assert_eq!(kind(svg.as_bytes()), Ok("image/svg+xml"));
        for (bytes, found) in [
            (&b""[..], "an empty file"),
            (b"GIF89a\xff\x00", "a file of another kind"),
            (b"<html><svg></svg></html>", "a text that is no SVG"),
            (b"<svg><a></svg>", "a text that is no SVG"),
            (b"hello", "a text that is no SVG"),
        ] {
            let error = kind(bytes).unwrap_err();
            assert!(error.starts_with(found), "{error}");
        }
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (day, text) in [(0, "1 January 1970"), (19_782, "29 February 2024"), (20_788, "1 December 2026")] {
            assert_eq!(ReportDate::of_day(day).text(), text);
        }
    }

    #[test]
    fn nothing_is_shown_that_is_not_given_and_texts_are_escaped() {
        let bare = ReportIdentity::default();
        assert!(!bare.header("shot", "").contains("letterhead"));
        let full = ReportIdentity { case: Some("7 < 8".to_owned()), author: Some(" ".to_owned()), ..bare };
        let (head, style) = (full.header("a < b", ""), full.print_style("A \"shot\" </style>"));
        assert!(head.contains("<dt>Case</dt><dd>7 &lt; 8</dd>") && !head.contains("Author"), "{head}");
        assert!(head.contains("<h1>a &lt; b</h1>"), "{head}");
        assert!(!style.contains(['<', '\'']) && style.contains("A \\000022 shot\\000022  \\00003c /style"), "{style}");
    }
}
