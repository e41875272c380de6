//! A batch in shards: what they give together is what one run prints, to the byte; what is there is not done again, and what is wrong is a result.

use crate::common::run;
use std::fs;

#[test]
fn shards_of_a_batch_are_the_whole() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let (code, _, err) = run(folder, "init beam");
    assert_eq!(code, 0, "{err}");
    let test = fs::read_to_string(folder.join("test.yaml")).unwrap();
    let name = test.lines().find(|l| l.starts_with("name:")).unwrap().to_string();
    for k in 1..=3 {
        fs::write(folder.join(format!("t{k}.yaml")), test.replacen(&name, &format!("name: {k}"), 1)).unwrap();
    }
    let ok = |line: &str| {
        let (code, out, err) = run(folder, line);
        assert_eq!(code, 0, "{line}: {err}");
        out
    };
    let asked = "batch update model.yaml t1.yaml t2.yaml t3.yaml";
    let whole = ok(&format!("{asked} --folder one -- --seed 3"));
    assert_eq!(whole.lines().count(), 3);
    for shard in ["2/2", "1/2"] {
        assert_eq!(ok(&format!("{asked} --folder two --shard {shard} -- --seed 3")), "");
    }
    let files = |of: &str| {
        let mut names: Vec<String> = fs::read_dir(folder.join(of))
            .unwrap()
            .map(|entry| format!("{of}/{}", entry.unwrap().file_name().to_string_lossy()))
            .collect();
        names.sort();
        names
    };
    let two = files("two");
    assert_eq!(ok(&format!("merge {} {} {}", two[2], two[0], two[1])), whole);

    // A line is what the verb answers alone.
    let line: serde_json::Value = serde_json::from_str(whole.lines().next().unwrap()).unwrap();
    let alone: serde_json::Value = serde_json::from_str(&ok("update model.yaml t1.yaml --seed 3 --json")).unwrap();
    assert_eq!(line["result"], alone);
    assert_eq!((line["tests"][0].as_str(), line["error"].is_null()), (Some("1"), true));

    // What is there is kept; what is damaged is done again.
    let file = folder.join(&two[0]);
    let (before, text) = (fs::metadata(&file).unwrap().modified().unwrap(), fs::read(&file).unwrap());
    assert_eq!(ok(&format!("{asked} --folder two -- --seed 3")), whole);
    assert_eq!(fs::metadata(&file).unwrap().modified().unwrap(), before);
    fs::write(&file, &text[..text.len() / 2]).unwrap();
    assert_eq!(ok(&format!("{asked} --folder two -- --seed 3")), whole);
    assert_eq!(fs::read(&file).unwrap(), text);

    // Another option, another job.
    ok(&format!("{asked} --folder two -- --seed 4"));
    assert_eq!(files("two").len(), 6);

    // What is wrong is a result, and what would write elsewhere is refused.
    fs::write(folder.join("t2.yaml"), "retune_test: 1\nname: wrong\nmodes: [{frequenzy: 3 Hz}]\n").unwrap();
    let (code, out, err) = run(folder, &format!("{asked} --folder three"));
    assert!(code == 1 && out.lines().count() == 3 && err.contains("1 job without a result"), "{code} {err}");
    assert!(out.contains("frequenzy") && out.contains("\"result\":null"), "{out}");
    let refused = |line: &str, what: &str| {
        let (code, out, err) = run(folder, line);
        assert!(code == 2 && out.is_empty() && err.contains(what), "{line}: {code} {err}");
    };
    refused(&format!("{asked} --folder two -- -o x.json"), "-o: the results of a batch are files of its folder");
    refused(&format!("{asked} --folder two -- --report=x.html"), "--report=x.html: the results of a batch");
    refused(&format!("{asked} --folder two --shard 3/2"), "3/2");
    refused(&format!("{asked} --folder model.yaml"), "cannot make the folder model.yaml");
    refused(&format!("merge {} model.yaml", two[0]), "model.yaml: it is not a result of `retune batch`");
    refused(&format!("merge {} --cases", two[0]), "which has no cases");
}
