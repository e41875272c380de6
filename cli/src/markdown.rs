//! Pages of the reference in Markdown: what `list`, `explain` and `schema` know, as `docs/reference` has it.

mod catalogue;
mod schema;
mod verbs;

pub(crate) use catalogue::{member, page};
pub(crate) use schema::keys;
pub(crate) use verbs::verbs;

/// What stands at the top of a generated page.
fn generated_by(command: &str) -> String {
    format!("<!-- Written by `{command}`; a test compares. Change what it is written from instead. -->\n")
}

/// A table.
pub(super) fn table(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<String> = head.iter().map(ToString::to_string).collect();
    let mut out = line(&head) + &line(&vec!["---".to_string(); head.len()]);
    for row in rows {
        out += &line(&row);
    }
    out
}

/// Text for a cell: one line, in which nothing ends the cell or begins a tag.
pub(super) fn cell(text: &str) -> String {
    paragraph(&text.split_whitespace().collect::<Vec<_>>().join(" ")).replace('|', "\\|")
}

/// Text in which nothing begins a tag, except within code.
pub(super) fn paragraph(text: &str) -> String {
    let mut is_code = false;
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        is_code ^= c == '`';
        if c == '<' && !is_code { out.push_str("&lt;") } else { out.push(c) }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{cell, table};

    #[test]
    fn nothing_in_a_cell_ends_it() {
        assert_eq!(cell("a | b\n  c <d> `<e>`"), "a \\| b c &lt;d> `<e>`");
        assert_eq!(table(&["a", "b"], [vec!["1".into(), "2".into()]]), "| a | b |\n| --- | --- |\n| 1 | 2 |\n");
    }
}
