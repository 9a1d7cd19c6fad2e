//! XMP: facts of the other tags for programs that read nothing else, and the model of the lens, for which DNG has no
//! words.
//!
//! Opcodes come near to most lenses and have no words for others. So that development from the file is that of the
//! render, the lens itself stands in properties of a namespace of our own, with the size of the active area that it
//! holds for: a program that crops the image leaves them behind.

use glam::DVec2;
use quick_xml::NsReader;
use quick_xml::events::Event;
use quick_xml::name::{Namespace, ResolveResult};

use crate::{Distortion, LensModel, RawMetadata};
use photosite_core::projection::{Intrinsics, Projection};

/// The namespace of the lens.
const LENS: &str = "http://ns.photosite/lens/1.0/";

/// An XMP packet; `size_px` is that of the active area.
pub(super) fn packet(metadata: &RawMetadata, size_px: [usize; 2]) -> String {
    let mut facts = vec![
        ("xmp:CreatorTool", concat!("photosite ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("tiff:Make", "photosite".to_owned()),
        ("tiff:Model", metadata.camera_model.clone()),
        ("exif:ExposureTime", ratio(metadata.exposure_time_s)),
    ];
    facts.extend(metadata.f_number.map(|f_number| ("exif:FNumber", ratio(f_number))));
    facts.extend(metadata.focal_length_m.map(|metres| ("exif:FocalLength", ratio(metres * 1e3))));
    let mut namespace = String::new();
    if let Some(Distortion::Lens(lens)) = &metadata.distortion {
        namespace = format!("\n   xmlns:lens=\"{LENS}\"");
        facts.extend(lens_facts(lens, size_px));
    }
    let facts: String =
        facts.iter().map(|(name, value)| format!("\n   {name}=\"{}\"", quick_xml::escape::escape(value))).collect();
    format!(
        "<?xpacket begin=\"\u{feff}\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>
<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">
 <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">
  <rdf:Description rdf:about=\"\"
   xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\"
   xmlns:tiff=\"http://ns.adobe.com/tiff/1.0/\"
   xmlns:exif=\"http://ns.adobe.com/exif/1.0/\"{namespace}{facts}/>
 </rdf:RDF>
</x:xmpmeta>
<?xpacket end=\"r\"?>"
    )
}

/// A fraction as XMP writes it.
fn ratio(value: f64) -> String {
    let fraction = crate::rational::rational(value);
    format!("{}/{}", fraction.n, fraction.d)
}

fn lens_facts(lens: &LensModel, size_px: [usize; 2]) -> Vec<(&'static str, String)> {
    let Intrinsics { fx, fy, cx, cy, skew } = lens.intrinsics;
    let mut facts = vec![
        ("lens:Projection", lens.projection.name().to_owned()),
        ("lens:Coefficients", list(&lens.projection.coefficients())),
        ("lens:FocalLengthPx", list(&[fx, fy])),
        ("lens:PrincipalPointPx", list(&[cx, cy])),
        ("lens:SkewPx", list(&[skew])),
        ("lens:PictureSizePx", list(&size_px.map(|n| n as f64))),
    ];
    facts.extend(lens.projection.xi().map(|xi| ("lens:Xi", list(&[xi]))));
    facts.extend(lens.max_angle_rad.map(|angle| ("lens:MaxAngleRad", list(&[angle]))));
    facts
}

/// List of numbers that read back unchanged.
fn list(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

/// The model of the lens, where a packet has one that holds for an active area of this size.
pub(super) fn read_lens(packet: &[u8], size_px: [usize; 2]) -> Option<LensModel> {
    let facts = facts_of(std::str::from_utf8(packet).ok()?)?;
    let text = |name: &str| facts.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str());
    let numbers = |name: &str| -> Option<Vec<f64>> {
        let numbers = text(name)?.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()));
        numbers.collect()
    };
    let pair = |name: &str| <[f64; 2]>::try_from(numbers(name)?).ok();
    let one = |name: &str| <[f64; 1]>::try_from(numbers(name)?).ok().map(|[x]| x);
    let ([fx, fy], [cx, cy]) = (pair("FocalLengthPx")?, pair("PrincipalPointPx")?);
    if fx <= 0.0 || fy <= 0.0 || pair("PictureSizePx")? != size_px.map(|n| n as f64) {
        return None;
    }
    let xi = text("Xi").map(|_| one("Xi")).map_or(Some(None), |xi| xi.filter(|xi| *xi >= 0.0).map(Some))?;
    let projection = Projection::named(text("Projection")?, &numbers("Coefficients")?, xi)?;
    let max_angle_rad = text("MaxAngleRad").map(|_| one("MaxAngleRad")).map_or(Some(None), |angle| angle.map(Some))?;
    let lens = LensModel { intrinsics: Intrinsics { fx, fy, cx, cy, skew: one("SkewPx")? }, projection, max_angle_rad };
    // Numbers of a damaged file may make a lens that sees nothing.
    lens.undistortion().source(DVec2::new(cx, cy)).map(|_| lens)
}

/// The properties of our namespace, as attributes or as elements: programs that change a packet may write either.
fn facts_of(packet: &str) -> Option<Vec<(String, String)>> {
    let mut reader = NsReader::from_str(packet);
    let ours = |found: &ResolveResult<'_>| *found == ResolveResult::Bound(Namespace(LENS));
    let (mut facts, mut open) = (Vec::new(), None);
    loop {
        let event = reader.read_event().ok()?;
        match event {
            Event::Eof => return Some(facts),
            Event::Start(tag) | Event::Empty(tag) => {
                let (namespace, local) = reader.resolver().resolve_element(tag.name());
                open = ours(&namespace).then(|| local.as_ref().to_owned());
                for attribute in tag.attributes() {
                    let attribute = attribute.ok()?;
                    let (namespace, local) = reader.resolver().resolve_attribute(attribute.key);
                    if ours(&namespace) {
                        facts.push((local.as_ref().to_owned(), attribute.value.into_owned()));
                    }
                }
            }
            Event::Text(text) => {
                if let Some(open) = open.take() {
                    facts.push((open, text.as_ref().to_owned()));
                }
            }
            // Models without coefficients have an element without text.
            Event::End(_) => facts.extend(open.take().map(|open| (open, String::new()))),
            Event::CData(_)
            | Event::Comment(_)
            | Event::Decl(_)
            | Event::PI(_)
            | Event::DocType(_)
            | Event::GeneralRef(_) => open = None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::projection::{BrownConrady, FisheyeProjection};

    fn lenses() -> Vec<LensModel> {
        let intrinsics = Intrinsics { fx: 512.25, fy: 1.0 / 3.0 + 500.0, cx: 320.5, cy: -7.125, skew: 0.1 };
        let distortion = BrownConrady { k: [0.1, -0.2, 0.0, 0.0, 0.0, 0.0], p: [1e-3, -1e-17], s: [0.0; 4] };
        let long = BrownConrady { k: [0.1, -0.2, 0.3, 0.1, 0.2, 0.3], p: [1e-3, 0.0], s: [1e-3, 2e-3, 0.0, -1e-5] };
        let lens = |projection, max_angle_rad| LensModel { intrinsics, projection, max_angle_rad };
        vec![
            lens(Projection::BrownConrady(distortion), None),
            lens(Projection::BrownConrady(long), Some(0.7)),
            lens(Projection::Polynomial { k: [0.1, 0.0] }, None),
            lens(Projection::Division { lambda: -0.1 }, None),
            lens(Projection::KannalaBrandt { k: [0.1, 0.2, 0.3, -1e-9] }, Some(1.4)),
            lens(Projection::Omnidirectional { xi: 1.1, distortion }, None),
            lens(Projection::ClassicalFisheye(FisheyeProjection::Equisolid), None),
            lens(Projection::ClassicalFisheye(FisheyeProjection::Stereographic), Some(1.4)),
            lens(Projection::ClassicalFisheye(FisheyeProjection::Orthographic), None),
        ]
    }

    fn packet_of(lens: LensModel) -> String {
        let metadata = RawMetadata { distortion: Some(Distortion::Lens(lens)), ..RawMetadata::default() };
        packet(&metadata, [640, 480])
    }

    #[test]
    fn lenses_come_back_to_the_last_bit_for_the_same_image_alone() {
        for lens in lenses() {
            let packet = packet_of(lens);
            assert_eq!(read_lens(packet.as_bytes(), [640, 480]), Some(lens), "{packet}");
            assert_eq!(read_lens(packet.as_bytes(), [640, 479]), None);
        }
        assert_eq!(read_lens(packet(&RawMetadata::default(), [640, 480]).as_bytes(), [640, 480]), None);
    }

    #[test]
    fn properties_may_be_elements_of_another_prefix() {
        for lens in lenses() {
            let elements: String = lens_facts(&lens, [640, 480])
                .into_iter()
                .map(|(name, value)| {
                    let name = name.replace("lens:", "L:");
                    format!("  <{name}>{value}</{name}>\n")
                })
                .collect();
            let packet = format!(
                "<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'>\n\
                 <rdf:Description rdf:about='' xmlns:L='{LENS}'>\n{elements}</rdf:Description></rdf:RDF></x:xmpmeta>"
            );
            assert_eq!(read_lens(packet.as_bytes(), [640, 480]), Some(lens));
        }
    }

    #[test]
    fn damaged_packets_are_no_lens_and_no_panic() {
        let packet = packet_of(lenses()[5]);
        for length in 0..packet.len() {
            let cut = &packet.as_bytes()[..length];
            assert!(read_lens(cut, [640, 480]).is_none_or(|lens| lens == lenses()[5]));
        }
        for (from, to) in [("512.25", "nan"), ("512.25", "-1"), ("1.1\"", "x\""), ("omnidirectional", "perspective")] {
            assert!(packet.contains(from));
            assert_eq!(read_lens(packet.replacen(from, to, 1).as_bytes(), [640, 480]), None, "{from} → {to}");
        }
    }
}
