//! The same facts as XMP, for programs that read nothing else.

use crate::raw::RawMetadata;

/// An XMP packet.
pub(super) fn packet(metadata: &RawMetadata) -> String {
    let mut facts = vec![
        ("xmp:CreatorTool", concat!("photosite ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("tiff:Make", "photosite".to_owned()),
        ("tiff:Model", metadata.camera_model.clone()),
        ("exif:ExposureTime", ratio(metadata.exposure_time_s)),
    ];
    facts.extend(metadata.f_number.map(|f_number| ("exif:FNumber", ratio(f_number))));
    facts.extend(metadata.focal_length_m.map(|metres| ("exif:FocalLength", ratio(metres * 1e3))));
    let facts: String =
        facts.iter().map(|(name, value)| format!("\n   {name}=\"{}\"", quick_xml::escape::escape(value))).collect();
    format!(
        "<?xpacket begin=\"\u{feff}\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>
<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">
 <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">
  <rdf:Description rdf:about=\"\"
   xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\"
   xmlns:tiff=\"http://ns.adobe.com/tiff/1.0/\"
   xmlns:exif=\"http://ns.adobe.com/exif/1.0/\"{facts}/>
 </rdf:RDF>
</x:xmpmeta>
<?xpacket end=\"r\"?>"
    )
}

/// A fraction as XMP writes it.
fn ratio(value: f64) -> String {
    let fraction = crate::raw::rational::rational(value);
    format!("{}/{}", fraction.n, fraction.d)
}
