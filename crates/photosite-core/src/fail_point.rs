//! Fail points: named places at which a test ends the program as if it had been killed.
//!
//! When the variable `PHOTOSITE_FAIL_POINT` is `NAME:N`, the program ends when it reaches the point of that name for
//! the N-th time: at once, with status 137 as after SIGKILL, and without putting anything away. Without the variable a
//! point costs one comparison. Points stand where files change, never in hot loops:
//!
//! | name | where |
//! |---|---|
//! | `file-written` | a file is complete under its temporary name |
//! | `file-named` | a file has got its name |
//! | `pass-ended` | a pass over the image is traced, and what it asks for is kept |
//! | `image-begun` | an image of a data set has a folder of its own, with nothing in it |
//! | `image-complete` | that folder has all its files, but not its name |

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Environment variable that names the fail point, see [`reach`].
const VARIABLE: &str = "PHOTOSITE_FAIL_POINT";
/// Exit status of a killed program: 128 and the number of SIGKILL.
const KILLED: i32 = 137;

/// Name of the fail point that ends the program, and the number of times it is reached until then.
fn wanted() -> Option<&'static (String, u32)> {
    static WANTED: OnceLock<Option<(String, u32)>> = OnceLock::new();
    let read = || {
        let text = std::env::var(VARIABLE).ok()?;
        let (name, count) = text.split_once(':')?;
        Some((name.to_owned(), count.parse().ok()?))
    };
    WANTED.get_or_init(read).as_ref()
}

/// Ends the program if `PHOTOSITE_FAIL_POINT` asks for it at this point.
pub fn reach(name: &str) {
    static REACHED: AtomicU32 = AtomicU32::new(0);
    let Some((wanted, count)) = wanted() else { return };
    if wanted == name && REACHED.fetch_add(1, Ordering::Relaxed) + 1 == *count {
        std::process::exit(KILLED);
    }
}
