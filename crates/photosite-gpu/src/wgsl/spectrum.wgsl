// Spectra at the wavelengths of a path, and spectra of colours; photosite-core's spectrum/flat.rs and spectrum/upsampling.

/// Values of a spectrum.
fn spectrum(id: u32, lambda_nm: vec4<f32>) -> vec4<f32> {
    let x = lambda_nm - LAMBDA_MIN_NM;
    let entry = min(vec4<u32>(x), vec4<u32>(SPECTRUM_ENTRIES - 2u));
    let part = x - vec4<f32>(entry);
    let start = id * SPECTRUM_ENTRIES;
    let a = spectra[start + entry.x];
    let b = spectra[start + entry.y];
    let c = spectra[start + entry.z];
    let d = spectra[start + entry.w];
    return vec4<f32>(a.x, b.x, c.x, d.x) + vec4<f32>(a.y, b.y, c.y, d.y) * part;
}

/// Values of a polynomial of homogeneous coordinates.
fn polynomial(coordinates: vec4<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    let t = (clamp(lambda_nm, vec4<f32>(360.0), vec4<f32>(830.0)) - 595.0) * (1.0 / 235.0);
    let p = (coordinates.x * t + coordinates.y) * t + coordinates.z;
    let length = max(sqrt(p * p + coordinates.w * coordinates.w), vec4<f32>(MIN_POSITIVE));
    return 0.5 + 0.5 * p / length;
}

const COLOUR_NODES = 32u;

fn colour_node(index: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(tables[params.colours + index]);
}

/// Reflectance of a linear sRGB colour with channels of 0 to 1; `reflectance_polynomial`.
fn reflectance_of(colour: vec3<f32>) -> vec4<f32> {
    let rgb = clamp(colour, vec3<f32>(0.0), vec3<f32>(1.0));
    if (rgb.x == rgb.y && rgb.y == rgb.z) {
        let value = rgb.x;
        return vec4<f32>(0.0, 0.0, value - 0.5, sqrt(max(value * (1.0 - value), 0.0)));
    }
    var largest = 2u;
    var zxy = rgb.zxy;
    if (rgb.x >= rgb.y && rgb.x >= rgb.z) {
        largest = 0u;
        zxy = rgb;
    } else if (rgb.y >= rgb.z) {
        largest = 1u;
        zxy = rgb.yzx;
    }
    let value = vec3<f32>(zxy.y / zxy.x, zxy.z / zxy.x, zxy.x);
    let near = sqrt(value);
    let far = sqrt(1.0 - value);
    let position = near / (near + far) * f32(COLOUR_NODES - 1u);
    let cell = min(vec3<u32>(position), vec3<u32>(COLOUR_NODES - 2u));
    let within = position - vec3<f32>(cell);
    let row = COLOUR_NODES;
    let plane = row * COLOUR_NODES;
    let start = largest * plane * COLOUR_NODES + cell.z * plane + cell.y * row + cell.x;
    let a = mix(colour_node(start), colour_node(start + 1u), within.x);
    let b = mix(colour_node(start + row), colour_node(start + row + 1u), within.x);
    let c = mix(colour_node(start + plane), colour_node(start + plane + 1u), within.x);
    let d = mix(colour_node(start + plane + row), colour_node(start + plane + row + 1u), within.x);
    return mix(mix(a, b, within.y), mix(c, d, within.y), within.z);
}

/// Spectrum of a linear sRGB tint of any brightness; `tint_spectrum`.
fn tint_spectrum(colour: vec3<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    let rgb = max(colour, vec3<f32>(0.0));
    let largest = max(rgb.x, max(rgb.y, rgb.z));
    if (largest <= 0.0) {
        return vec4<f32>(0.0);
    }
    return polynomial(reflectance_of(rgb / largest * 0.5), lambda_nm) * (2.0 * largest);
}
