//! Stories of decks: formats, continuations, INCLUDE, changes in place.

use super::*;
use std::io::{Error, ErrorKind};
use std::path::Path;

fn deck(text: &str) -> Result<Deck, DeckError> {
    Deck::read(Path::new("deck.bdf"), &mut |_| Ok(text.as_bytes().to_vec()))
}

/// One grid in small, large and free field, with tabs, with a comment behind it: the same five fields.
#[test]
fn all_formats_give_the_same_fields() {
    let text = "\
GRID    7       101     1.5     -2.     3.+1                    $ small
GRID*   7               101             1.5             -2.
*       3.+1
GRID,7,101,1.5,-2.,3.+1
GRID*,7,101,1.5,-2.
*,3.+1
GRID\t7\t101\t1.5\t-2.\t3.+1
grid    7       101     1.5     -2.     3.+1
";
    let deck = deck(text).unwrap();
    assert_eq!(deck.cards().len(), 6);
    for id in deck.cards() {
        let card = deck.card(id);
        assert_eq!(deck.name(id), "GRID");
        assert_eq!(card.id_at(2, "ID").unwrap(), 7);
        assert_eq!(card.id_at(3, "CP").unwrap(), 101);
        assert_eq!(card.vector(4, "X").unwrap(), [1.5, -2.0, 30.0], "{:?}", card.place());
        assert_eq!(card.len(), 6);
    }
}

#[test]
fn continuations_number_on_and_lists_count_through() {
    let text = "\
SPC1    1       123     1       THRU    5       7       9       11      +A
+A      13      THRU    19      BY      3
$ a comment between
        21
RBE2,70001,1030,123456,10102,10103
";
    let deck = deck(text).unwrap();
    let spc = deck.card(deck.cards().next().unwrap());
    assert_eq!(spc.ids_from(4, "G").unwrap(), [1, 2, 3, 4, 5, 7, 9, 11, 13, 16, 19, 21]);
    assert_eq!(spc.components(3, "C").unwrap(), [true, true, true, false, false, false]);
    assert_eq!(deck.comment(&deck.comments()[0]), "a comment between");
}

#[test]
fn sections_are_told_apart_and_subcases_override() {
    let text = "\
INIT MASTER(S)
SOL 103
CEND
TITLE = a wing
SPC = 5
SUBCASE 1
  METHOD(STRUCTURE) = 101
SUBCASE 2
  SPC = 7
BEGIN BULK
GRID,1
ENDDATA 123
this is not a card, and nobody reads it
";
    let deck = deck(text).unwrap();
    assert_eq!(deck.solution(), Some("103"));
    let case = deck.case_control();
    assert_eq!((case.value("METHOD", None), case.value("SPC", None)), (Some("101"), Some("5")));
    assert_eq!((case.value("SPC", Some(2)), case.value("MPC", None)), (Some("7"), None));
}

/// What is wrong is told with file, line, card and field.
#[test]
fn mistakes_are_told_with_their_place() {
    let read = deck("GRID,1,,x,2.\n\nCBAR    7       12\n").unwrap();
    let mut cards = read.cards();
    let grid = read.card(cards.next().unwrap());
    let error = grid.vector(4, "X1").unwrap_err();
    assert_eq!(
        error.to_string(),
        "deck.bdf:1: GRID 1, field 4 (X1): `x` where a real number with a decimal point is expected"
    );
    let bar = read.card(cards.next().unwrap());
    assert_eq!(
        bar.id_at(4, "GA").unwrap_err().to_string(),
        "deck.bdf:3: CBAR 7, field 4 (GA): an integer above zero is missing"
    );
    for (text, message) in [
        ("", "deck.bdf: there are no bulk data in it: is it a Nastran deck?"),
        (
            "+A      1\n",
            "deck.bdf:1: it continues a card, and none stands before it; continuations must follow their card",
        ),
        (
            "BEGIN BULK\nGRID,1\nBEGIN SUPER=2\n",
            "deck.bdf:3: BEGIN: superelements are not read: give the deck of one structure",
        ),
        ("GRID,1\n1234\n", "deck.bdf:2: `1234` is not the name of a card"),
        ("GRID,1\nINCLUDE 'nowhere.dat'\n", "deck.bdf:2: INCLUDE: there is no file `nowhere.dat` beside the deck"),
    ] {
        assert_eq!(deck(text).unwrap_err().to_string(), message);
    }
    let fails = Deck::read(Path::new("deck.bdf"), &mut |_| Err(Error::new(ErrorKind::NotFound, "not there")));
    assert_eq!(fails.unwrap_err().to_string(), "deck.bdf: it cannot be read: not there");
}

#[test]
fn files_include_each_other_in_any_case_and_not_in_a_circle() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("Parts")).unwrap();
    std::fs::write(at("deck.bdf"), "BEGIN BULK\nINCLUDE 'parts\\GRID.dat'\nGRID,3\nENDDATA\n").unwrap();
    std::fs::write(at("Parts/grid.DAT"), "GRID,1\nINCLUDE more.dat\n").unwrap();
    std::fs::write(at("Parts/more.dat"), "GRID,2\n").unwrap();
    let read = |name: &str| Deck::read(&at(name), &mut |p| std::fs::read(p));
    let deck = read("deck.bdf").unwrap();
    let ids: Vec<u32> = deck.cards().map(|c| deck.card(c).id_at(2, "ID").unwrap()).collect();
    assert_eq!((ids, deck.sources().len(), deck.includes().len()), (vec![1, 2, 3], 3, 2));
    std::fs::write(at("Parts/more.dat"), "INCLUDE 'grid.dat'\n").unwrap();
    assert!(read("deck.bdf").unwrap_err().message.contains("includes itself"));
}

/// New values stand in the columns of the old; every other byte is as it was.
#[test]
fn changes_keep_every_other_byte() {
    let text = "\
BEGIN BULK\r
$ the wing\r
PBEAM   1003    903     3.4368850.1223291.029e+0        0.044824        $ tuned\r
MAT1,903,2592711.,1075031.,,0.006794 $ foam\r
PBUSH*  7               K                          1.0E6           1.0E6\r
CBAR    8       3       1\r
ENDDATA\r
";
    let deck = deck(text).unwrap();
    let ids: Vec<CardId> = deck.cards().collect();
    let mut changes = Changes::default();
    changes.real(&deck, (ids[0], 4, "A"), 3.5).unwrap();
    changes.real(&deck, (ids[0], 5, "I1"), 0.125).unwrap();
    changes.real(&deck, (ids[1], 3, "E"), 2.6e6).unwrap();
    changes.real(&deck, (ids[1], 8, "TREF"), 20.0).unwrap();
    changes.real(&deck, (ids[2], 5, "K2"), 1.23456789e7).unwrap();
    changes.real(&deck, (ids[3], 6, "X1"), 1.0).unwrap();
    changes.real(&deck, (ids[3], 8, "X3"), 2.0).unwrap();
    changes.add(["CONM2,9,1,,.5".to_string()]);
    let expected = "\
BEGIN BULK\r
$ the wing\r
PBEAM   1003    903     3.5     .125    1.029e+0        0.044824        $ tuned\r
MAT1,903,2.6+6,1075031.,,0.006794,,20. $ foam\r
PBUSH*  7               K                          1.0E6      12345678.9\r
CBAR    8       3       1               1.              2.\r
$ added\r
CONM2,9,1,,.5\r
ENDDATA\r
";
    let out = &changes.apply(&deck, "$ added")[0];
    let read = super::tests::deck(out).unwrap();
    let values = |d: &Deck, i: usize, n: usize| d.card(d.cards().nth(i).unwrap()).real(n, "X").unwrap();
    assert_eq!(values(&read, 1, 3), 2.6e6);
    let strip = |t: &str| t.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(strip(out), strip(expected), "{out}");
    for (i, n, value) in [
        (0, 4, 3.5),
        (0, 5, 0.125),
        (0, 6, 1.029),
        (0, 8, 0.044824),
        (1, 8, 20.0),
        (2, 5, 12345678.9),
        (3, 6, 1.0),
        (3, 8, 2.0),
    ] {
        assert_eq!(values(&read, i, n), value, "{i} {n}\n{out}");
    }
    assert!(changes.integer(&deck, (ids[0], 3, "MID"), 123_456_789).is_err());
    assert!(changes.real(&deck, (ids[3], 20, "PA"), 1.0).unwrap_err().message.contains("continuation"));
}

/// Bytes from a stream of random ones over a deck: an answer or an error, never a panic.
#[test]
fn mutated_decks_end() {
    let seed = "SOL 103\nCEND\nSPC=1\nBEGIN BULK\nGRID*   7               101             1.5\n*       3.+1\nSPC1,1,123,1,THRU,50\nPBARL   3       4               BAR\n        .5      1.48\nENDDATA\n";
    crate::data::mutate::all(&[seed.as_bytes().to_vec()], 5000, |bytes| {
        let Ok(deck) = Deck::read(Path::new("deck.bdf"), &mut |_| Ok(bytes.to_vec())) else { return false };
        for id in deck.cards() {
            let card = deck.card(id);
            for n in 1..20 {
                let _ = (card.real(n, "X"), card.id_at(n, "X"), card.components(n, "X"), card.field(n));
            }
            let _ = card.ids_from(4, "X");
        }
        true
    });
}
