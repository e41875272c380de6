//! `retune manual`

use crate::args::{Cli, Manual};
use crate::output::{Failure, print, shown};
use crate::{DONE, writing};
use clap::CommandFactory;
use retune::catalogue::counted;

pub(crate) fn run(args: &Manual) -> Result<u8, Failure> {
    let mut command = Cli::command();
    command.build();
    let mut pages = Vec::new();
    let verbs = command.get_subcommands().filter(|verb| verb.get_name() != "help");
    for (name, command) in std::iter::once(("retune".to_string(), &command))
        .chain(verbs.map(|verb| (format!("retune-{}", verb.get_name()), verb)))
    {
        // What a usage calls `retune check` is `retune-check` among the pages of a manual.
        let page = clap_mangen::Man::new(command.clone().name(name.clone())).title(name.to_uppercase());
        let mut text = Vec::new();
        page.render(&mut text)?;
        pages.push((args.output.join(format!("{name}.1")), String::from_utf8_lossy(&text).into_owned()));
    }
    std::fs::create_dir_all(&args.output)
        .map_err(|e| Failure::text(format!("cannot make the folder {}: {e}", shown(&args.output))))?;
    for (path, _) in &pages {
        writing::check_output(path, args.overwrite.force)?;
    }
    let n = pages.iter().filter(|(path, text)| writing::write(path, text)).count();
    print(&format!("written: {} in {}\n", counted(n, "page"), shown(&args.output)));
    Ok(DONE)
}
