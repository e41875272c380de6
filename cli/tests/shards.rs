//! A benchmark in shards: what they give together is what one run prints, and what is not all of one run is refused.

use crate::common::run;
use std::fs;

/// Four cases, with their whole diagnoses.
const ASKED: &str =
    "benchmark diagnosis --structure cantilever --null 0 --effects 0 --faults 1 --outside 0 --modes 5 --case sensor-s";

#[test]
fn shards_of_a_benchmark_are_the_whole() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let ok = |line: &str| {
        let (code, out, err) = run(folder, line);
        assert_eq!(code, 0, "{line}: {err}");
        out
    };
    let refused = |line: &str| {
        let (code, out, err) = run(folder, line);
        assert!(code == 2 && out.is_empty(), "{line}: {code} {out}");
        err
    };
    let whole = ok(&format!("{ASKED} -o whole.json"));
    assert!(whole.contains("sensor-s") && whole.contains("ln B"), "{whole}");
    ok(&format!("{ASKED} --shard 1/2 -o one.json"));
    fs::write(folder.join("two.json"), ok(&format!("{ASKED} --shard 2/2"))).unwrap();

    // To the byte, in any order, as text and as JSON.
    assert_eq!(ok("merge two.json one.json -o merged.json"), whole);
    let [json, merged] = ["whole.json", "merged.json"].map(|name| fs::read_to_string(folder.join(name)).unwrap());
    assert_eq!(merged, json);
    assert_eq!(ok("merge one.json two.json --json"), json);

    // What is there is not run again, what is another is not overwritten.
    let before = fs::metadata(folder.join("one.json")).unwrap().modified().unwrap();
    let (code, _, err) = run(folder, &format!("{ASKED} --shard 1/2 -o one.json"));
    assert!(code == 0 && err.contains("one.json is shard 1/2 of this benchmark already; nothing is run"), "{err}");
    assert_eq!(fs::metadata(folder.join("one.json")).unwrap().modified().unwrap(), before);
    let err = refused(&format!("{ASKED} --shard 2/2 -o one.json"));
    assert!(err.contains("one.json exists: it is shard 1/2; give --force"), "{err}");
    let err = refused(&format!("{ASKED} --seed 7 --shard 1/2 -o one.json"));
    assert!(err.contains("`seed` is 1 there and 7 here") && err.contains("--force"), "{err}");

    let err = refused("merge one.json");
    assert!(err.contains("1 shard missing: 2/2"), "{err}");
    let err = refused("merge one.json two.json one.json");
    assert!(err.contains("one.json and one.json are both shard 1/2"), "{err}");
    let err = refused("merge one.json whole.json");
    assert!(err.contains("whole.json: it is not a file that `retune benchmark --shard` has written"), "{err}");
    let err = refused("merge one.json absent.json");
    assert!(err.contains("cannot read absent.json"), "{err}");
    let changed = fs::read_to_string(folder.join("two.json")).unwrap().replacen("\"seed\":1", "\"seed\":2", 1);
    fs::write(folder.join("changed.json"), changed).unwrap();
    let err = refused("merge one.json changed.json");
    assert!(err.contains("changed.json: it is damaged"), "{err}");
    fs::write(folder.join("half.json"), &merged[..merged.len() / 2]).unwrap();
    let err = refused("merge half.json");
    assert!(err.contains("half.json: it is not a file"), "{err}");
    let err = refused("merge one.json two.json -o two.json --force");
    assert!(err.contains("two.json"), "{err}");
}

#[test]
fn shards_that_there_are_not_are_refused() {
    let temporary = tempfile::tempdir().unwrap();
    for (words, what) in [
        ("--shard 0/2", "the shards of 2 are 1/2 ... 2/2"),
        ("--shard 3/2", "the shards of 2 are 1/2 ... 2/2"),
        ("--shard two", "3/8"),
        ("--shard 1/2 --json", "--json"),
        ("--shard 1/2 --cases", "--cases"),
    ] {
        let (code, _, err) = run(temporary.path(), &format!("{ASKED} {words}"));
        assert!(code == 2 && err.contains(what), "{words}: {err}");
    }
}
