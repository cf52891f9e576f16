//! Tables of Markdown.

/// The rows of all tables of a Markdown text, as cells; headers and rulers left out.
pub(crate) fn rows(markdown: &str) -> Vec<Vec<String>> {
    let lines: Vec<&str> = markdown.lines().map(str::trim).collect();
    let ruler = |line: &str| line.starts_with('|') && line.chars().all(|c| "|:- ".contains(c));
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let header = lines.get(at + 1).is_some_and(|next| ruler(next));
        if line.starts_with('|') && !ruler(line) && !header {
            found.push(cells(line));
        }
    }
    found
}

/// The cells of a row; `\|` stands for a bar inside a cell.
fn cells(line: &str) -> Vec<String> {
    let marked = line.replace("\\|", "\u{1}");
    let inner = marked.trim_matches('|');
    inner.split('|').map(|cell| cell.replace('\u{1}', "|").trim().to_owned()).collect()
}

/// What stands between backticks.
pub(crate) fn quoted(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}
