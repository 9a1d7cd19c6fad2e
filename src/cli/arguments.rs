//! What arguments of several commands mean.

use std::ops::Range;

use photosite::Error;

/// Starts as many threads as are asked for.
pub(super) fn start_threads(threads: Option<u16>) -> photosite::Result<()> {
    /// So many that wait for each other slow down a small machine only a little.
    const FEW: usize = 256;
    let Some(threads) = threads.map(usize::from) else { return Ok(()) };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let usage = |message: String| Error::Usage {
        message,
        help: Some(format!("this machine runs {cores} at once; more than these make nothing faster").into()),
    };
    let most = FEW.max(4 * cores);
    if threads > most {
        return Err(usage(format!("--threads {threads}: at most {most} can be asked for")));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|reason| usage(format!("cannot start {threads} threads: {reason}")))
}

/// A range of whole numbers as arguments have it, `A..B`: from A up to, but without, B.
pub(super) fn parse_range(text: &str) -> Result<Range<u32>, String> {
    let number = |part: &str| part.trim().parse::<u32>().ok();
    let ends = text.split_once("..").and_then(|(a, b)| Some((number(a)?, number(b)?)));
    match ends {
        Some((a, b)) if a < b => Ok(a..b),
        Some(_) => Err("the first number must be below the second".to_owned()),
        None => Err("write two whole numbers, for example 0..10".to_owned()),
    }
}
