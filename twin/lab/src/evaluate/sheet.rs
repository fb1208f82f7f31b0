//! A table as plain cells: CSV for programs, HTML for the page.

use twin_scenario::markup::escaped;

/// Head and lines of a table; every line is as long as the head.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Names of the columns, with their units.
    pub head: Vec<String>,
    /// Cells of each line; an empty cell has no figure.
    pub rows: Vec<Vec<String>>,
}

impl Sheet {
    /// A table with a head and no lines.
    pub fn new<S: Into<String>>(head: impl IntoIterator<Item = S>) -> Self {
        Self { head: head.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// The table as CSV by RFC 4180, with a line feed at the end of each line.
    pub fn csv(&self) -> String {
        let line = |cells: &Vec<String>| {
            cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",") + "\n"
        };
        std::iter::once(&self.head).chain(&self.rows).map(line).collect()
    }

    /// The table as an HTML element `table`.
    pub fn html(&self) -> String {
        let row = |cells: &Vec<String>, tag: &str| {
            let cells = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)));
            format!("<tr>{}</tr>", cells.collect::<String>())
        };
        let body: String = self.rows.iter().map(|cells| row(cells, "td")).collect();
        format!("<table><thead>{}</thead><tbody>{body}</tbody></table>", row(&self.head, "th"))
    }
}

fn quoted(cell: &str) -> String {
    if cell.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

/// The value with `decimals`; empty if it is unknown.
pub fn figure(value: Option<f64>, decimals: usize) -> String {
    value.filter(|value| value.is_finite()).map_or_else(String::new, |v| format!("{v:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_quotes_and_markup_stay_one_cell() {
        let mut sheet = Sheet::new(["row", "Δ, %"]);
        sheet.rows.push(vec!["a \"b\" <c>".to_owned(), figure(Some(1.25), 1)]);
        sheet.rows.push(vec!["d".to_owned(), figure(Some(f64::NAN), 1)]);
        assert_eq!(sheet.csv(), "row,\"Δ, %\"\n\"a \"\"b\"\" <c>\",1.2\nd,\n");
        assert!(sheet.html().contains("<td>a &quot;b&quot; &lt;c&gt;</td><td>1.2</td>"));
    }
}
