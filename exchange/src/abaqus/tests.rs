//! Decks that are damaged: an answer or an error, never a panic.

use super::import_keywords;
use crate::{ImportOptions, SYSTEMS, Solver};
use retune::deck::KeywordDeck;
use std::path::Path;

const PARTS: &str = "*Heading
a part twice
*Part, name=Plate
*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*Element, type=C3D8R
1, 1, 2, 3, 4, 5, 6, 7, 8
*Nset, nset=all, generate
1, 8, 1
*Elset, elset=all
1
*Surface, name=top
all, S2
*Solid Section, elset=all, material=steel, orientation=o
,
*Orientation, name=o
1., 0., 0., 0., 1., 0.
3, 30.
*End Part
*Assembly, name=A
*Instance, name=one, part=Plate
*End Instance
*Instance, name=two, part=Plate
0., 0., 1.
0., 0., 1., 0., 0., 2., 90.
*End Instance
*Node
1, 0.5, 0.5, 3.
*Element, type=MASS, elset=m
1, 1
*Mass, elset=m
2.
*Nset, nset=foot, instance=one
1, 2, 3, 4
*Elset, elset=low, instance=two
1
*Surface, type=ELEMENT, name=bottom
low, S1
*Tie, name=t
bottom, one.top
*Nset, nset=ref
1
*Coupling, constraint name=c, ref node=ref, surface=two.top
*Distributing
1, 6
*End Assembly
*Material, name=steel
*Density
7800.
*Elastic, type=engineering constants
2e11, 2e11, 2e11, .3, .3, .3, 8e10, 8e10,
8e10
*Boundary
foot, ENCASTRE
*Step, perturbation
*Frequency
3
*End Step
";

const FLAT: &str = "*NODE, NSET=N
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
4, 2., 1., 0.
5, 0., 1., 0.
*ELEMENT, TYPE=B32, ELSET=B
1, 1, 2, 3
*ELEMENT, TYPE=S3, ELSET=S
2, 1, 3, 4
*ELEMENT, TYPE=T3D2, ELSET=T
3, 1, 5
*ELEMENT, TYPE=SPRING2, ELSET=K
4, 4, 5
*ELEMENT, TYPE=SPRINGA, ELSET=A
5, 2, 5
*ELEMENT, TYPE=ROTARYI, ELSET=R
6, 5
*ELEMENT, TYPE=DASHPOTA, ELSET=D
7, 2, 4
*BEAM SECTION, ELSET=B, MATERIAL=M, SECTION=I
.05, .1, .05, .06, .005, .005, .004
0., 1., 0.
*SHELL SECTION, ELSET=S, MATERIAL=M, OFFSET=SPOS
.01
*SOLID SECTION, ELSET=T, MATERIAL=M
1e-4
*SPRING, ELSET=K
1, 2
1000.
*SPRING, ELSET=A

500.
*ROTARY INERTIA, ELSET=R
1., 1., 1.
*DASHPOT, ELSET=D

3.
*MATERIAL, NAME=M
*ELASTIC
2e11, .3
*DENSITY
7800.
*TRANSFORM, NSET=N, TYPE=C
0., 0., 0., 0., 0., 1.
*EQUATION
2
4, 1, 1., 5, 1, -1.
*MPC
BEAM, 5, 1
*RIGID BODY, NSET=N, REF NODE=1
*BOUNDARY
1, 1, 3
5, 2
*STEP
*FREQUENCY
2
*END STEP
";

#[test]
fn mutated_decks_end() {
    let options =
        ImportOptions { system: &SYSTEMS[0], subcase: None, parameter_per_property: true, solver: Solver::Abaqus };
    crate::mutate::all(&[PARTS.as_bytes().to_vec(), FLAT.as_bytes().to_vec()], 20_000, |bytes| {
        let deck = KeywordDeck::read(Path::new("deck.inp"), &mut |_| Ok(bytes.to_vec()));
        deck.is_ok_and(|deck| import_keywords(&deck, options).is_ok())
    });
}
