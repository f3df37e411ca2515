//! `granflow new`: writes a built-in case.

use crate::args::New;
use crate::catalogue;
use crate::failure::Failure;
use crate::session::Session;
use crate::text::count;
use granflow_case::store::DirWriter;
use granflow_dict::nearest;
use std::path::PathBuf;

/// Runs the command.
///
/// # Errors
/// [`Failure`].
pub(crate) fn command(session: &mut Session, args: &New) -> Result<(), Failure> {
    let Some(case) = catalogue::ALL.iter().find(|c| c.name == args.name) else {
        let names: Vec<&str> = catalogue::ALL.iter().map(|c| c.name).collect();
        let near = nearest(&args.name, names.iter().copied());
        let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
        let message = format!("there is no built-in case `{}`", args.name);
        return Err(Failure::refused(message, format!("{near}known are {}", names.join(", "))));
    };
    let dir = args.dir.clone().unwrap_or_else(|| PathBuf::from(case.name));
    let shown = dir.display().to_string();
    // A dangling link is something too.
    if dir.symlink_metadata().is_ok() {
        let message = format!("`{shown}` exists already: nothing was written");
        let help = format!("give another directory: granflow new {} DIR", case.name);
        return Err(Failure::refused(message, help));
    }
    let mut writer = DirWriter::begin(&dir)?;
    for (path, bytes) in case.files {
        writer.file_plain(path, bytes)?;
    }
    writer.commit()?;
    session.out.say(&format!("{} in {shown}: {}", count(case.files.len(), "file"), case.summary()));
    session.out.say(&format!("run it with: granflow run {shown}"));
    Ok(())
}
