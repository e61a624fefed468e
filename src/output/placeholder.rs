//! Page that an FMU leaves in the place of the report: it names the files, and the command that draws the report.

use super::summary::RunSummary;

/// Returns the page as HTML.
pub(super) fn placeholder_page(summary: &RunSummary) -> String {
    let name = summary.scene.replace('&', "&amp;").replace('<', "&lt;");
    let ending = if summary.completed { "The run has reached its end" } else { "The run was ended early" };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<title>{name} — ballistic-gel</title>\n\
         </head>\n<body>\n<h1>{name}</h1>\n<p>{ending}, at {:e} s. Its figures are in <code>summary.json</code>, its \
         curves in the tables beside it (<code>.csv</code>); <code>series.pvd</code> opens in ParaView.</p>\n\
         <p>The report with the shot in three dimensions, its plots and its validity is made from these files by</p>\n\
         <pre>gelfmu report FOLDER</pre>\n<p>where FOLDER is the folder of this page.</p>\n</body>\n</html>\n",
        summary.end_time
    )
}
