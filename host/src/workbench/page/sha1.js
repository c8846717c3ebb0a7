// SHA-1 (FIPS 180-4) and HMAC (RFC 2104): a page on plain http has no crypto.subtle. They prove that the page knows
// the secret of this start, which stays off the line.

function bytes(text) { return [...new TextEncoder().encode(text)]; }

function sha1(message) {
	const data = [...message, 0x80];
	while (data.length % 64 !== 56) data.push(0);
	const bits = message.length * 8;
	data.push(0, 0, 0, 0, bits >>> 24 & 255, bits >>> 16 & 255, bits >>> 8 & 255, bits & 255);
	let [a0, b0, c0, d0, e0] = [0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476, 0xc3d2e1f0];
	const rotate = (n, by) => n << by | n >>> 32 - by;
	for (let at = 0; at < data.length; at += 64) {
		const w = [];
		for (let i = 0; i < 16; i++) {
			const j = at + 4 * i;
			w[i] = data[j] << 24 | data[j + 1] << 16 | data[j + 2] << 8 | data[j + 3];
		}
		for (let i = 16; i < 80; i++) w[i] = rotate(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
		let [a, b, c, d, e] = [a0, b0, c0, d0, e0];
		for (let i = 0; i < 80; i++) {
			const [f, k] = i < 20 ? [b & c | ~b & d, 0x5a827999]
				: i < 40 ? [b ^ c ^ d, 0x6ed9eba1]
				: i < 60 ? [b & c | b & d | c & d, 0x8f1bbcdc]
				: [b ^ c ^ d, 0xca62c1d6];
			const next = rotate(a, 5) + f + e + k + w[i] | 0;
			[e, d, c, b, a] = [d, c, rotate(b, 30), a, next];
		}
		[a0, b0, c0, d0, e0] = [a0 + a | 0, b0 + b | 0, c0 + c | 0, d0 + d | 0, e0 + e | 0];
	}
	return [a0, b0, c0, d0, e0].flatMap(n => [n >>> 24 & 255, n >>> 16 & 255, n >>> 8 & 255, n & 255]);
}

export function hmac(secret, message) {
	let key = bytes(secret);
	if (key.length > 64) key = sha1(key);
	key = [...key, ...new Array(64 - key.length).fill(0)];
	const inner = sha1([...key.map(b => b ^ 0x36), ...bytes(message)]);
	const outer = sha1([...key.map(b => b ^ 0x5c), ...inner]);
	return outer.map(b => b.toString(16).padStart(2, '0')).join('');
}
