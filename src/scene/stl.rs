//! Parser of binary and ASCII STL files.

use crate::geometry::TriangleSurface;
use crate::math::Vector3;

/// Unreadable STL file: text found, with its location, and text expected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct StlError {
    pub found: String,
    pub expected: &'static str,
}

const HEADER: usize = 80;
const RECORD: usize = 50;
/// Lines of the longest ASCII file that is read: seven to a triangle, and one more for comments and names of solids.
const MOST_LINES: usize = 8 * TriangleSurface::MOST_TRIANGLES;

/// Triangles of a binary or ASCII file, in its own units.
///
/// A file whose length matches the triangle count in its header is binary, whatever word it begins with.
pub(super) fn triangles(bytes: &[u8]) -> Result<Vec<[Vector3; 3]>, StlError> {
    let count = bytes.get(HEADER..HEADER + 4).map(|count| u32::from_le_bytes(fixed(count)) as usize);
    let length = count.and_then(|count| count.checked_mul(RECORD)?.checked_add(HEADER + 4));
    if length == Some(bytes.len()) {
        return Ok(bytes[HEADER + 4..].chunks_exact(RECORD).map(record).collect());
    }
    match std::str::from_utf8(bytes) {
        Ok(text) if begins_with_solid(text) => ascii(text),
        Ok(_) | Err(_) => Err(StlError {
            found: format!(
                "{} bytes that are no STL: neither text that begins with solid nor {}",
                bytes.len(),
                declared_triangles(count)
            ),
            expected: "a whole binary or ASCII STL file",
        }),
    }
}

/// Returns true if the text begins with `solid` and has no zero bytes: a binary header may begin with that word too.
fn begins_with_solid(text: &str) -> bool {
    text.split_whitespace().next().is_some_and(|word| word.eq_ignore_ascii_case("solid")) && !text.contains('\0')
}

fn declared_triangles(count: Option<usize>) -> String {
    match count {
        Some(count) => format!("the {count} triangles of {RECORD} bytes that a binary header promises"),
        None => "a binary header".to_owned(),
    }
}

fn fixed<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}

/// Triangle of a binary record: three corners after the normal, which is not needed.
fn record(bytes: &[u8]) -> [Vector3; 3] {
    let number = |i: usize| f64::from(f32::from_le_bytes(fixed(&bytes[12 + 4 * i..])));
    [0, 3, 6].map(|i| Vector3::new(number(i), number(i + 1), number(i + 2)))
}

/// Triangles of an ASCII file: the lines that begin with `vertex`, three to an `outer loop`.
fn ascii(text: &str) -> Result<Vec<[Vector3; 3]>, StlError> {
    let (mut triangles, mut corners) = (Vec::new(), Vec::with_capacity(3));
    for (number, line) in (1..).zip(text.lines()) {
        if number > MOST_LINES {
            let found = format!("more than {MOST_LINES} lines");
            return Err(StlError { found, expected: "the seven lines of each triangle, of 500000 triangles at most" });
        }
        let mut words = line.split_whitespace();
        let refuse = |expected| Err(StlError { found: format!("`{}` on line {number}", line.trim()), expected });
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => match coordinates(words) {
                Some(corner) => corners.push(corner),
                None => return refuse("three numbers after vertex"),
            },
            Some("endloop") => match corners[..] {
                [a, b, c] => {
                    triangles.push([a, b, c]);
                    corners.clear();
                }
                _ => return refuse("three lines with vertex before it"),
            },
            Some("solid" | "facet" | "outer" | "endfacet" | "endsolid") | None => {}
            Some(_) => return refuse("a line of an ASCII STL file: solid, facet, outer, vertex, end..."),
        }
    }
    if corners.is_empty() {
        return Ok(triangles);
    }
    Err(StlError { found: "an end in the middle of a triangle".to_owned(), expected: "endloop, endfacet and endsolid" })
}

fn coordinates<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vector3> {
    let numbers: Vec<f64> = words.take(4).map(str::parse).collect::<Result<_, _>>().ok()?;
    let [x, y, z] = numbers[..] else { return None };
    Some(Vector3::new(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid a name\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 -0.5\n   VERTEX 1e0 2 3\n\
        vertex 4 5 6\n  endloop\n endfacet\nendsolid a name\n";

    fn expected() -> Vec<[Vector3; 3]> {
        vec![[Vector3::new(0.0, 0.0, -0.5), Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0)]]
    }

    /// Binary file whose header begins like a text.
    fn binary() -> Vec<u8> {
        let mut bytes = b"solid, but binary".to_vec();
        bytes.resize(HEADER, b' ');
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend([0; 12]);
        for x in expected()[0].iter().flatten() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
        bytes
    }

    fn refused(bytes: &[u8]) -> String {
        let error = triangles(bytes).unwrap_err();
        format!("{}; {}", error.found, error.expected)
    }

    #[test]
    fn both_formats_give_the_same_triangles() {
        assert_eq!(triangles(TEXT.as_bytes()), Ok(expected()));
        assert_eq!(triangles(TEXT.replace('\n', "\r\n").as_bytes()), Ok(expected()));
        assert_eq!(triangles(&binary()), Ok(expected()));
        assert_eq!(triangles(b"solid\nendsolid\n"), Ok(vec![]));
    }

    #[test]
    fn a_broken_file_is_refused_with_the_place() {
        let bad = TEXT.replace("4 5 6", "4 5");
        assert_eq!(refused(bad.as_bytes()), "`vertex 4 5` on line 6; three numbers after vertex");
        let bad = TEXT.replace("4 5 6", "4 5 six");
        assert_eq!(refused(bad.as_bytes()), "`vertex 4 5 six` on line 6; three numbers after vertex");
        let bad = TEXT.replace("vertex 4 5 6\n", "");
        assert_eq!(refused(bad.as_bytes()), "`endloop` on line 6; three lines with vertex before it");
        let bad = TEXT.replace("outer loop", "inner loop");
        assert!(refused(bad.as_bytes()).starts_with("`inner loop` on line 3; a line of an ASCII STL file"));
        let (bad, _) = TEXT.split_once("  endloop").unwrap();
        assert!(refused(bad.as_bytes()).starts_with("an end in the middle of a triangle"));
    }

    #[test]
    fn a_file_cut_short_says_what_its_header_promised() {
        let bytes = binary();
        assert!(refused(&bytes[..100]).starts_with("100 bytes that are no STL: neither text that begins with solid"));
        assert!(refused(b"").starts_with("0 bytes") && refused(b"").contains("nor a binary header"));
        let mut other = bytes[..100].to_vec();
        other[..5].copy_from_slice(b"aaaaa");
        assert!(refused(&other).contains("nor the 1 triangles of 50 bytes that a binary header promises"));
    }
}
