//! Names of nodes, and what comments of a deck say.

/// Name of the node of a grid.
pub(super) fn node(id: u32) -> String {
    format!("n{id}")
}

/// A comment that a reader of the model wants: no ruler, no rule of signs, no card that was commented out, no mark of a preprocessor.
pub(super) fn worth_keeping(text: &str) -> bool {
    let letters = text.chars().filter(|c| c.is_alphabetic()).count();
    let first = text.split([' ', ',', '\t']).next().unwrap_or_default().trim_end_matches('*').to_uppercase();
    let is_card = super::rule(&first).is_some() || first.starts_with("INCLUDE") || text.starts_with('+');
    let is_ruler = text.contains("---") && letters < 4;
    letters >= 3 && !is_card && !is_ruler && text.len() < 400
}

/// A name that a preprocessor wrote above a property: Femap, HyperMesh, Patran.
pub(super) fn property_name(comment: &str, id: u32) -> Option<String> {
    let number = id.to_string();
    let lower = comment.to_ascii_lowercase();
    let name = if let Some(at) = lower.find("property ").filter(|_| lower.contains("femap")) {
        let (own, name) = comment[at + 9..].split_once(':')?;
        (own.trim() == number).then(|| name.trim())?
    } else if lower.starts_with("hmname prop") {
        let (own, name) = comment[11..].split_once('"')?;
        (own.trim() == number).then(|| name.split('"').next().unwrap_or(name).trim())?
    } else if let Some(at) = lower.find("for region :") {
        comment[at + 12..].trim()
    } else {
        return None;
    };
    (!name.is_empty()).then(|| name.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_of_people_are_told_from_rulers_and_dead_cards() {
        for text in
            ["Left bolts", "--------------conm2 for servos at left wing --------------", "1010 -1020 Inner wing"]
        {
            assert!(worth_keeping(text), "{text}");
        }
        for text in [
            "1------2------3------4------5",
            "=====",
            "RBE2    70001   2070    123456  20004",
            "",
            "INCLUDE x.dat",
            "+cb1  0.5",
        ] {
            assert!(!worth_keeping(text), "{text}");
        }
    }

    #[test]
    fn names_of_preprocessors_are_found() {
        let cases = [
            ("Femap with NX Nastran Property 3 : Wing skin", "Wing skin"),
            ("HMNAME PROP                3\"spar\" 4", "spar"),
            ("Elements and Element Properties for region : rib_2", "rib_2"),
        ];
        for (comment, name) in cases {
            assert_eq!(property_name(comment, 3).as_deref(), Some(name));
        }
        assert_eq!(property_name("Femap Property 4 : other", 3), None);
        assert_eq!(property_name("property of nobody", 3), None);
    }
}
