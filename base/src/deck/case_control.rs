//! Case control: what each subcase asks for.

/// What a subcase, or what stands above all, says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Subcase {
    /// Its number; 0 above all subcases.
    pub id: u32,
    /// Its commands: the word without its options, and what stands behind `=`.
    pub commands: Vec<(String, String)>,
}

/// Case control of a deck.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CaseControl {
    /// What holds in all subcases.
    pub above: Subcase,
    /// The subcases, in order.
    pub subcases: Vec<Subcase>,
    /// Sets of numbers: number of the set, what stands behind `=`.
    pub sets: Vec<(u32, String)>,
}

impl CaseControl {
    pub(super) fn parse(lines: &[(u32, u32, String)]) -> Self {
        let mut out = Self::default();
        // A statement goes on behind a comma.
        let mut statements: Vec<String> = Vec::new();
        let mut open = false;
        for (_, _, line) in lines {
            match statements.last_mut().filter(|_| open) {
                Some(last) => last.push_str(line),
                None => statements.push(line.clone()),
            }
            open = line.ends_with(',');
        }
        for statement in statements {
            let upper = statement.to_uppercase();
            let (head, value) = match statement.split_once('=') {
                Some((head, value)) => (head.trim().to_uppercase(), value.trim().to_string()),
                None => {
                    let (head, value) = upper.split_once(' ').unwrap_or((&upper, ""));
                    (head.trim().to_string(), value.trim().to_string())
                }
            };
            let word = head.split(['(', ' ']).next().unwrap_or_default().to_string();
            if word == "SUBCASE" {
                let id = value.split_whitespace().next().and_then(|v| v.parse().ok()).unwrap_or(0);
                out.subcases.push(Subcase { id, commands: Vec::new() });
            } else if let Some(id) = head.strip_prefix("SET ").and_then(|n| n.trim().parse().ok()) {
                out.sets.push((id, value));
            } else {
                let subcase = out.subcases.last_mut().unwrap_or(&mut out.above);
                subcase.commands.push((head, value));
            }
        }
        out
    }

    /// What a command says in a subcase, or above all: `SPC`, `METHOD`.
    pub fn value(&self, word: &str, subcase: Option<u32>) -> Option<&str> {
        let chosen = match subcase {
            Some(id) => self.subcases.iter().find(|s| s.id == id),
            None => self.subcases.first(),
        };
        let of = |s: &'_ Subcase| -> Option<usize> {
            s.commands.iter().rposition(|(head, _)| head.split(['(', ' ']).next().is_some_and(|h| h.trim() == word))
        };
        chosen
            .and_then(|s| of(s).map(|i| s.commands[i].1.as_str()))
            .or_else(|| of(&self.above).map(|i| self.above.commands[i].1.as_str()))
    }
}
