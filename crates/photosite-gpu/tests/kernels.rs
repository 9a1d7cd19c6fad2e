//! Kernels as text: naga accepts them for every card, and both sides lay out what they share alike.
#![cfg(feature = "gpu")]

use photosite_gpu::develop::shaders::development;
use photosite_gpu::expose::shaders::exposure;
use photosite_gpu::shaders::wavefront;
use wgpu::naga;

#[test]
fn naga_accepts_all_kernels() {
    // Without any features, and with all.
    for features in [0, u32::MAX] {
        let text = wavefront(features);
        let names = ["arrive", "count", "extend", "generate", "generate_camera_rays", "shade", "shadow", "update_film"];
        accepts(&text, &names, &["Params", "Film"]);
    }
    let of_development = [
        "bilinear",
        "choose_directions",
        "chroma_again",
        "chroma_at_green",
        "encode",
        "green_again",
        "interpolate_green",
        "malvar",
        "other_again",
        "other_colour",
        "signal",
    ];
    accepts(&development(), &of_development, &["Params"]);
}

#[test]
fn naga_accepts_the_kernel_of_exposures() {
    let module = accepted(&exposure());
    let (_, words) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("ExposureWords")).expect("words");
    let naga::TypeInner::Struct { members, span } = &words.inner else { panic!("{words:?}") };
    // Words follow each other without a gap, as Rust writes them: each member has words of 4 bytes alone
    let sizes = members.iter().map(|member| module.types[member.ty].inner.size(module.to_ctx()));
    let ends = sizes.scan(0, |end, size| {
        *end += size;
        Some(*end)
    });
    let offsets: Vec<u32> = members.iter().map(|member| member.offset).skip(1).chain([*span]).collect();
    assert!(ends.eq(offsets));
}

fn accepts(text: &str, kernels: &[&str], blocks: &[&str]) {
    let module = accepted(text);
    let mut names: Vec<&str> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, kernels);

    // Uniform blocks are whole numbers of 16 bytes, and every field has its place in the order of Rust's table.
    for &name in blocks {
        let (_, block) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).expect("a block");
        let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("{block:?}") };
        assert_eq!((span % 16, *span as usize), (0, 4 * members.len()));
        for (i, member) in members.iter().enumerate() {
            assert_eq!(member.offset as usize, 4 * i, "{:?}", member.name);
        }
    }
}

/// Module of a text that every card takes.
fn accepted(text: &str) -> naga::Module {
    let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    let all = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(all, naga::valid::Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    module
}
