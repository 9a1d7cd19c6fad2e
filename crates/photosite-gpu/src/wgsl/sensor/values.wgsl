// What all stages of the sensor share: two neighbours of a row, which are worked on together, and numbers of single
// precision that every driver rounds alike.

/// A number as it is stored: no driver joins operations across it, as it does not know that the word is 0.
fn rounded(x: vec2<f32>) -> vec2<f32> {
    return bitcast<vec2<f32>>(bitcast<vec2<u32>>(x) ^ vec2<u32>(exposure.zero));
}

fn rounded_sum(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return rounded(a + b);
}

fn rounded_product(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return rounded(a * b);
}

/// Numbers of both columns of a list.
fn of_columns(list: u32, x: u32) -> vec2<f32> {
    let last = exposure.width - 1u;
    return vec2<f32>(bitcast<f32>(tables[list + x]), bitcast<f32>(tables[list + min(x + 1u, last)]));
}

fn of_row(list: u32, y: u32) -> f32 {
    return bitcast<f32>(tables[list + y]);
}

/// Place of the word of a pixel in a list of some pixels (signal/words.rs), or NONE.
fn listed(list: u32, x: u32, y: u32) -> u32 {
    if (list == NONE) {
        return NONE;
    }
    var low = tables[list + y];
    var high = tables[list + y + 1u];
    // Pixels are pairs of words by rising columns
    while (low < high) {
        let middle = low + ((high - low) / 4u) * 2u;
        let column = tables[middle];
        if (column == x) {
            return middle + 1u;
        }
        if (column < x) {
            low = middle + 2u;
        } else {
            high = middle;
        }
    }
    return NONE;
}
