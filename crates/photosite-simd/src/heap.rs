//! Heap allocator that ends the program with a plain message when memory runs out.
//!
//! The standard library's answer to a failed allocation may ask for memory itself: with `RUST_BACKTRACE=1` it collects
//! a backtrace while it holds a lock, and where that fails, too, the program waits for itself for ever. This heap
//! writes its message from the stack, and ends the program at once. A program, or a module of Python, chooses it by
//! `#[global_allocator]`; libraries do not.

#![allow(unsafe_code, reason = "an allocator is unsafe by its trait; this one hands all work to the system's")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::sync::OnceLock;

/// The status of a program that ran out of memory, as of other failures.
#[cfg(unix)]
const FAILED: i32 = 1;
/// Message before and after the number of bytes that cannot be allocated.
static MESSAGE: OnceLock<[&'static str; 2]> = OnceLock::new();
const PLAIN: [&str; 2] =
    ["error: out of memory: ", " bytes could not be allocated; lower the resolution, or free some memory\n"];

/// The system's heap, which ends the program on standard error with status 1 when memory runs out.
///
/// There is no cleanup then: leftovers are removed by the next run, as after SIGKILL. Allocations that may fail
/// (`try_reserve`) end the program, too; callers that expect a failure check the available memory beforehand.
pub struct Heap;

impl Heap {
    /// Sets the message before and after the number of bytes. The first call counts.
    pub fn set_message(before: &'static str, after: &'static str) {
        let _ = MESSAGE.set([before, after]);
    }
}

// SAFETY: every call is the system allocator's, with the arguments that came in; what it returns is handed on unless it
// is null, after which nothing returns.
unsafe impl GlobalAlloc for Heap {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `alloc`.
        or_end(unsafe { System.alloc(layout) }, layout.size())
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        or_end(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    #[inline]
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`; the block came from the system's heap.
        unsafe { System.dealloc(block, layout) }
    }

    #[inline]
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the contract of `realloc`; the block came from the system's heap.
        or_end(unsafe { System.realloc(block, layout, size) }, size)
    }
}

#[inline]
fn or_end(block: *mut u8, size: usize) -> *mut u8 {
    if block.is_null() {
        end(size)
    }
    block
}

/// Ends the program without asking for memory or for a lock.
#[cold]
#[inline(never)]
fn end(size: usize) -> ! {
    let [before, after] = MESSAGE.get().copied().unwrap_or(PLAIN);
    let mut text = [0; 256];
    let mut rest = &mut text[..];
    let _ = write!(rest, "{before}{size}{after}");
    let free = rest.len();
    #[cfg(unix)]
    // SAFETY: the bytes are there, and only read; nothing depends on a reader. Nothing returns, and exit handlers,
    // which may ask for memory, are not run.
    unsafe {
        libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len() - free);
        libc::_exit(FAILED)
    }
    #[cfg(not(unix))]
    std::process::abort()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_keep_what_is_in_them() {
        let layout = Layout::array::<u8>(100).expect("a layout");
        // SAFETY: a block of 100 bytes is asked for, zeroed, grown to 5000, written within and given back.
        unsafe {
            let block = Heap.alloc_zeroed(layout);
            block.add(99).write(7);
            let block = Heap.realloc(block, layout, 5000);
            assert_eq!([block.read(), block.add(99).read()], [0, 7]);
            Heap.dealloc(block, Layout::array::<u8>(5000).expect("a layout"));
        }
    }
}
