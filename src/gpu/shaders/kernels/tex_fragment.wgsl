// A ray at a textured surface as an operand.

fn take_fragment() -> TexFragment {
    var fragment: TexFragment;
    fragment.d = take3();
    fragment.n = take3();
    let s = take3();
    let t = take3();
    fragment.tangents = array<vec3f, 2>(s, t);
    let of_b = take2();
    let of_c = take2();
    fragment.st = array<vec2f, 2>(of_b, of_c);
    fragment.triangle = take_u32() != 0u;
    return fragment;
}
