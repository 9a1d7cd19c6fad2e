// Writes streams.json: streams of every mode and filter of EXT_meshopt_compression and KHR_meshopt_compression, packed by
// meshoptimizer's own encoder, with what its own decoder makes of them. See make.py.

const fs = require('fs');
const path = require('path');

async function main() {
	const { MeshoptEncoder: encoder } = await import(require.resolve('meshoptimizer/encoder'));
	const { MeshoptDecoder: decoder } = await import(require.resolve('meshoptimizer/decoder'));
	await Promise.all([encoder.ready, decoder.ready]);
	const streams = [];
	const add = (name, count, stride, packed, mode, filter) => {
		const unpacked = new Uint8Array(count * stride);
		decoder.decodeGltfBuffer(unpacked, count, stride, packed, mode, filter);
		const text = (bytes) => Buffer.from(bytes).toString('base64');
		streams.push({ name, count, stride, mode, filter, packed: text(packed), unpacked: text(unpacked) });
	};
	const wave = (count, width, f) => Float32Array.from({ length: count * width }, (_, i) => f(Math.floor(i / width), i % width));
	const bytes = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);

	// More elements than a block has, with changes of every size.
	const rough = Uint8Array.from({ length: 300 * 4 }, (_, i) => (i % 4 ? (i * i * (i % 4)) >> (i % 7) : i >> 5));
	const still = new Uint8Array(270 * 4).fill(7);
	const words = bytes(Uint16Array.from({ length: 20 * 4 }, (_, i) => 1000 * (i % 4) + 37 * i));
	const reals = bytes(wave(20, 3, (i, c) => Math.sin(i / 5 + c) * 10 ** c));
	for (const version of [0, 1]) {
		for (const level of [0, 3]) {
			const encode = (data, count, stride) => encoder.encodeVertexBufferLevel(data, count, stride, level, version);
			for (const [kind, data, stride] of [['rough', rough, 4], ['still', still, 4], ['words', words, 8], ['reals', reals, 12]]) {
				if (version === 0 && level > 0) continue;
				add(`${kind}-v${version}-${level}`, data.length / stride, stride, encode(data, data.length / stride, stride), 'ATTRIBUTES', 'NONE');
			}
		}
	}
	const filtered = (name, data, count, stride, filter) =>
		add(name, count, stride, encoder.encodeGltfBuffer(data, count, stride, 'ATTRIBUTES', 0), 'ATTRIBUTES', filter);
	const directions = wave(20, 4, (i, c) => [Math.cos(i) * 0.8, Math.sin(i) * 0.8, i % 2 ? 0.6 : -0.6, 1][c]);
	filtered('directions-8', encoder.encodeFilterOct(directions, 20, 4, 8), 20, 4, 'OCTAHEDRAL');
	filtered('directions-16', encoder.encodeFilterOct(directions, 20, 8, 12), 20, 8, 'OCTAHEDRAL');
	const turns = wave(20, 4, (i, c) => (c === i % 4 ? Math.cos(i / 9) : c === (i + 1) % 4 ? Math.sin(i / 9) : 0));
	filtered('turns', encoder.encodeFilterQuat(turns, 20, 8, 14), 20, 8, 'QUATERNION');
	for (const mode of ['Separate', 'SharedVector']) {
		filtered(`real-${mode}`, encoder.encodeFilterExp(new Float32Array(reals.buffer), 20, 12, 15, mode), 20, 12, 'EXPONENTIAL');
	}
	const colours = wave(20, 4, (i, c) => (i * (c + 1) % 21) / 20);
	filtered('colours-8', encoder.encodeFilterColor(colours, 20, 4, 8), 20, 4, 'COLOR');
	filtered('colours-16', encoder.encodeFilterColor(colours, 20, 8, 12), 20, 8, 'COLOR');

	// A strip of triangles, some that share nothing, and some that come again.
	const triangles = [];
	for (let i = 0; i < 40; i++) triangles.push(i, i + 1 + (i & 1), i + 2 - (i & 1));
	triangles.push(7, 99, 3, 500, 2, 70000, 0, 1, 2, 41, 43, 42, 1, 0, 41);
	for (const stride of [2, 4]) {
		const kept = stride === 2 ? Uint16Array.from(triangles, (i) => i % 65536) : Uint32Array.from(triangles);
		add(`triangles-${stride}`, kept.length, stride, encoder.encodeIndexBuffer(bytes(kept), kept.length, stride), 'TRIANGLES', 'NONE');
		add(`indices-${stride}`, kept.length, stride, encoder.encodeIndexSequence(bytes(kept), kept.length, stride), 'INDICES', 'NONE');
	}
	const lines = streams.map((stream) => JSON.stringify(stream));
	fs.writeFileSync(path.join(__dirname, 'streams.json'), `[\n${lines.join(',\n')}\n]\n`);
}

main();
