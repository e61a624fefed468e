//! Reads the arrays of a grid file (`.vtu`) as VTK does: appended raw data, zlib blocks behind a header of `UInt64`.

use std::io::Read;

/// Bytes of an array, by the line of its head.
pub struct GridArray {
    pub line: String,
    pub bytes: Vec<u8>,
}

/// All arrays of a file, in the order of its head.
pub fn arrays(file: &[u8]) -> Vec<GridArray> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = file.windows(mark.len()).position(|window| window == mark).unwrap();
    let head = std::str::from_utf8(&file[..start]).unwrap();
    assert!(head.contains("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\""), "{head}");
    let data = &file[start + mark.len()..];
    let read = |line: &str| {
        let offset = line.split_once("offset=\"").and_then(|(_, rest)| rest.split_once('"')).unwrap().0;
        GridArray { line: line.to_owned(), bytes: inflate(&data[offset.parse::<usize>().unwrap()..]) }
    };
    head.lines().filter(|line| line.starts_with("<DataArray ")).map(read).collect()
}

/// The blocks of an array, inflated: the number of blocks, their size, that of a smaller last one or 0, and the
/// compressed size of each.
fn inflate(data: &[u8]) -> Vec<u8> {
    let number = |i: usize| u64::from_le_bytes(data[8 * i..8 * (i + 1)].try_into().unwrap()) as usize;
    let (blocks, size, last) = (number(0), number(1), number(2));
    let (mut all, mut at) = (vec![], 8 * (3 + blocks));
    for block in 0..blocks {
        let length = number(3 + block);
        let before = all.len();
        flate2::read::ZlibDecoder::new(&data[at..at + length]).read_to_end(&mut all).unwrap();
        let expected = if block + 1 == blocks && last > 0 { last } else { size };
        assert_eq!(all.len() - before, expected, "block {block} of {blocks}");
        at += length;
    }
    all
}
