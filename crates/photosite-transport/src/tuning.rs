//! Constants that decide the speed of a render and nothing else: no image depends on them.
//!
//! All were found on an AMD EPYC of family 25 (Zen 4: AVX-512, 1 MB of L2 cache a core, 32 MB of L3 cache), most on one
//! thread. "Parts" and "scale" are the benches of those names, "renders" whole renders against the program before.

/// Primitives at most of a scene that is scanned without a hierarchy, and vertices of its triangles. Renders: at 36
/// triangles 1.26 times as fast as through the hierarchy with sixteen lanes, with spheres among them 1.17 times, and
/// 1.05 times with eight lanes; at 60 triangles 1.12 and 0.97 times. A hierarchy of one node that is walked without a
/// stack, in either order, without packets or by AVX-512, comes no closer: the time goes into leaves that are not full.
pub(crate) const LINEAR_SCAN_MAX: usize = 48;

/// Rays that a linear scan sorts together by the axis of their direction, so that each of three kinds fills the lanes.
/// At most 256, since they are numbered by bytes.
pub(crate) const LINEAR_SCAN_BATCH: usize = 256;

/// Greatest distance between the origins of the rays of a packet along an axis, as a part of the scene's diagonal.
/// Renders: 1.05 to 1.08 times as fast at 32 000 triangles as without this bound.
pub(crate) const PACKET_MAX_DISTANCE: f32 = 0.01;

/// Square of the least cosine between two rays of a packet: 1°. In fine meshes rays that are farther apart soon part,
/// and take less time interleaved. Scale: half of it through 10 million triangles, where the first of sixteen is 2°
/// from the last.
pub(crate) const PACKET_MIN_COSINE_SQUARED: f32 = 0.9997;

/// Rays that are traversed interleaved, at most 31. Scale: 0.95 of the time of 8 at 10 million triangles, at 1 million
/// the same.
pub(crate) const INTERLEAVE: usize = 24;

/// Blocks of triangles, of 160 bytes each, from which on rays often wait for the memory and are traversed interleaved.
/// Renders and scale: smaller scenes took 1.1 to 1.3 times as long interleaved.
pub(crate) const BLOCKS_BEYOND_CACHES: usize = 1 << 16;

/// Triangles from which on it pays to prefetch those that were hit. Renders.
pub(crate) const TRIANGLES_BEYOND_CACHES: usize = 1 << 15;

/// Cost of a leaf in visits of a node, for the surface area heuristic. Parts.
pub(crate) const LEAF_COST: f32 = 0.7;

/// Primitives at most of a part of a large mesh that is built by itself: parts are built in parallel, and each takes
/// little memory while it is. Scale: the most memory in use fell from 250 to 112 bytes a triangle at 1 million
/// triangles.
pub(crate) const BUILD_CHUNK_SIZE: usize = 1 << 16;
