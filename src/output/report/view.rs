//! The shot in three dimensions, and the script of the page.

use crate::output::view::{self, ViewFrame};
use crate::scene::Scene;

/// Style of the view and of the live plots, written by `report-page/build.sh`.
pub(super) const STYLE: &str = include_str!("page/page.css");
/// Script of the page, written by `report-page/build.sh` from `report-page/src`.
const SCRIPT: &str = include_str!("page/page.js");
/// Licences of the libraries in the script.
const LICENCES: &str = include_str!("page/licences.txt");

/// Script that unpacks and starts the script of the page, written without the reserved characters of XML. A browser that
/// cannot do so shows pictures and drawn plots.
const START: &str = "const unpack = async (text) => {
  const packed = Uint8Array.from(atob(text.split(',').pop().trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const script = document.createElement('script');
  script.textContent = await new Response(stream).text();
  document.body.append(script);
};
if ('DecompressionStream' in window) unpack(document.getElementById('page-script').textContent);";

/// Returns the place of the view with its data, open at the time `moment`, s; empty without frames.
pub(super) fn place(scene: &Scene, moment: f64, frames: &[ViewFrame]) -> String {
    view::data(scene, moment, frames).map_or(String::new(), |data| {
        format!(
            "<div id=\"view\" hidden=\"hidden\"></div>\n<script type=\"application/json\" \
             id=\"view-data\">{data}</script>\n"
        )
    })
}

/// Returns the script of the page, compressed, and the licences of its libraries.
pub(super) fn script() -> String {
    let packed = view::packed_text(SCRIPT.as_bytes());
    format!(
        "<details class=\"licences\"><summary>Licences of the script of this page</summary>\n<pre>{}</pre></details>\n\
         <script type=\"text/plain\" id=\"page-script\">{packed}</script>\n<script>\n{START}\n</script>\n",
        super::format::escape(LICENCES)
    )
}
