//! How much tests look at: enough to see a mistake each time, all of it when asked.

/// Whether the environment asks for all (`RETUNE_SLOW=1`).
pub(crate) fn is_asked() -> bool {
    std::env::var("RETUNE_SLOW").is_ok_and(|v| v == "1")
}

/// Of a number of seeds, as many as run each time; all when asked.
pub(crate) fn seeds<T>(few: T, all: T) -> T {
    if is_asked() { all } else { few }
}
