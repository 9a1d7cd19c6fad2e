//! Hints to the memory system: values that will be read soon, and large pages.

#![allow(unsafe_code, reason = "an instruction and a call of the system that change no value")]

/// Asks the processor to bring a value into its caches, because it will be read soon.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    for offset in (0..size_of::<T>()).step_by(64) {
        let address = std::ptr::from_ref(value).cast::<i8>().wrapping_add(offset);
        // SAFETY: the instruction is a hint; it reads nothing that the program could observe, at whatever address.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(address);
        }
        // SAFETY: the same.
        #[cfg(target_arch = "aarch64")]
        unsafe {
            std::arch::asm!("prfm pldl1keep, [{}]", in(reg) address.addr(), options(nomem, nostack, preserves_flags));
        }
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = value;
}

/// Asks the system to keep a vector's memory, its spare capacity included, in pages of 2 MB instead of 4 kB: rays in
/// large scenes spend much of their time looking up where pages are.
pub fn prefer_huge_pages<T>(values: &Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        let start = values.as_ptr().cast::<u8>();
        let skipped = start.align_offset(PAGE);
        let len = (values.capacity() * size_of::<T>()).saturating_sub(skipped) / PAGE * PAGE;
        if len > 0 {
            // SAFETY: whole pages of the vector's own memory; the advice changes how they are kept, not what they hold.
            // Where the system does not follow it, nothing happens.
            unsafe { libc::madvise(start.wrapping_add(skipped).cast_mut().cast(), len, libc::MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = values;
}

/// Copy without spare capacity, in [large pages](prefer_huge_pages).
pub fn compact<T: Copy>(values: &[T]) -> Vec<T> {
    let mut all = Vec::with_capacity(values.len());
    prefer_huge_pages(&all);
    all.extend_from_slice(values);
    all
}
