//! The choices of algorithm as closed sets of named values.

use crate::literals::literals;

literals! {
    /// What the probe line keeps of the ellipse.
    FootprintRule {
        /// Its axes: m = λ2, and the line as long as λ1 (Schilling).
        Paper = "paper",
        /// Its second moments: the probes' own width and their spread together have the ellipse's variance.
        Moments = "moments",
    } default Paper
}

literals! {
    /// How the number of probes follows from the line length M and the probe width m (texels).
    Count {
        /// clamp(⌈M/m − 2⁻⁸⌉, 1, max).
        Ceil = "ceil",
        /// clamp(⌊M/m + ½⌋, 1, max).
        Round = "round",
        /// TEXRAM: the next power of two that is at least the `ceil` count.
        Pow2 = "pow2",
        /// Feline: max(1, ⌊2ρ − ½⌋) probes over a line of length 2(M − m), end points included.
        Feline = "feline",
    } default Ceil
}

literals! {
    /// Where the direction of the probe line comes from.
    Axis {
        /// Schilling: sine and cosine from the angle table.
        EigenTable = "eigen-table",
        /// The eigenvector itself, normalised.
        EigenExact = "eigen-exact",
        /// The longest column of [D s·B'], as GPUs do with the longer screen derivative.
        LongerDerivative = "longer-derivative",
    } default EigenTable
}

literals! {
    /// Weights of the probes along the line.
    Weights {
        /// All alike.
        Box = "box",
        /// e^(−2x²), x = offset over half the line, normalised to sum exactly 1.
        Gaussian = "gaussian",
        /// e^(−x²) with the same x and the same sum, symmetric.
        Bell = "bell",
    } default Box
}

literals! {
    /// How the minor axis λ2 is found.
    Minor {
        /// Equation 17 of the paper: ½(a + c − √…), which cancels for thin ellipses.
        Paper = "paper",
        /// λ1·λ2 = √det K.
        Det = "det",
    } default Paper
}

literals! {
    /// The substitute for the derivative of the modified normal.
    Dnmod {
        /// ∂n of the interpolated normal, as in the paper.
        Paper = "paper",
        /// ∂n⊥ = ∂n − n⟨n,∂n⟩/⟨n,n⟩ of the interpolated normal.
        Normal = "normal",
        /// ∂n⊥ + b1 ∂e1 + b2 ∂e2: the local frame turns with the normal.
        Frame = "frame",
    } default Normal
}

literals! {
    /// Where the entries of the angle table lie inside −45°…+45°.
    Placement {
        /// Entry k at −45° + 90°·k/n; 0° is an entry.
        Edges = "edges",
        /// Entry k at −45° + 90°·(k + ½)/n, the centre of its bin.
        Centres = "centres",
    } default Edges
}

literals! {
    /// The values that are interpolated between texels and levels of the roughness pyramid.
    RoughnessInterpolation {
        /// The moments; B is formed after the interpolation.
        Moments = "moments",
        /// d1, d2, d3, because B is what the paper stores.
        Factors = "factors",
    } default Moments
}

literals! {
    /// Where the mean curvature of the bump map inside a footprint is counted.
    Curvature {
        /// In the roughness pyramid, as in the paper.
        Pyramid = "pyramid",
        /// In ∂n; its trend is taken out of the pyramid (the paper's footnote 2).
        Surface = "surface",
    } default Pyramid
}

literals! {
    /// Whose rules of a ray cone hold.
    ConeRules {
        /// The formulas of the note.
        Note = "note",
        /// OptiX Toolkit's code: no reflection, refraction or scatter from ¼ rad on; a scatter goes away from
        /// zero and ends diffuse at ±¼ rad; the projection keeps the sign of w.
        Otk = "otk",
    } default Note
}

literals! {
    /// What a scatter writes that OptiX Toolkit's code calls diffuse (`cone.rules = "otk"`).
    SetDiffuse {
        /// Angle ¼, width |w|, as was meant.
        Angle = "angle",
        /// Angle |w|, width ¼: the two exchanged, as the code has it.
        Exchanged = "exchanged",
    } default Angle
}

literals! {
    /// How ddx and ddy follow from dPdx and dPdy on a general surface.
    ConeGradient {
        /// The note's quotients of dot products, exact where dPds ⟂ dPdt.
        Otk = "otk",
        /// The 2×2 normal equations: exact for any dPds, dPdt.
        Gram = "gram",
    } default Gram
}

literals! {
    /// Gradients of a bare cone on a cube map.
    ConeEnv {
        /// The constant 2α/π per [0, 1] of a face.
        Otk = "otk",
        /// The Jacobian of the face coordinates.
        Exact = "exact",
    } default Exact
}

literals! {
    /// Which footprint a texture request takes from the ray.
    ConeMetric {
        /// The ray cones.
        Cone = "cone",
        /// The distance along the path times a pixel's angle, whatever curved surfaces did to the ray.
        Distance = "distance",
    } default Cone
}

literals! {
    /// The content of a 2-D texture beyond its edge.
    Wrap {
        /// The texture again.
        Repeat = "repeat",
        /// Its edge texels.
        Clamp = "clamp",
        /// The texture, every second time mirrored.
        Mirror = "mirror",
    } default Repeat
}

literals! {
    /// How HIT finds its next ray parameter.
    Method {
        /// The paper's: towards the far point (eq. 2) until a step overshoots, then between both ends (eq. 3).
        FalsePosition = "false-position",
        /// Before an overshoot the line through the last two results, at most 4·dist(R) long; eq. 3 after it.
        Secant = "secant",
        /// False position; on a second result on the same side in a row the other end's residual is halved.
        Illinois = "illinois",
    } default FalsePosition
}

literals! {
    /// How a distance is read from its cube map.
    LookUp {
        /// The texel that the direction meets.
        Nearest = "nearest",
        /// Bilinear between four texels of level 0.
        Bilinear = "bilinear",
    } default Bilinear
}

literals! {
    /// The shape of a ray cone's footprint at the hit.
    HitFootprint {
        /// A disc across the ray.
        Disc = "disc",
        /// The cone's cut with the wall's plane.
        Plane = "plane",
    } default Disc
}

literals! {
    /// What HIT does with a ray that starts outside of the reference surface.
    Outside {
        /// Stops there with the status `outside`.
        Stop = "stop",
        /// Goes on, as the paper's HLSL does.
        Hlsl = "hlsl",
    } default Stop
}

literals! {
    /// How a ray's search for its hit ended.
    HitStatus {
        /// The last ratio lies within 1 ± τ.
        Converged = "converged",
        /// The steps ran out.
        MaxIterations = "max-iterations",
        /// No step is left: a denominator of 0, a step of 0, or a bracket of one unit.
        Stalled = "stalled",
        /// Nothing lies in the ray's direction: the map's distance there is infinite.
        Escaped = "escaped",
        /// The ray starts on the reference surface.
        AtSurface = "at-surface",
        /// The ray starts outside of the reference surface.
        Outside = "outside",
    } default MaxIterations
}

literals! {
    /// How texels are stored in memory.
    TexelFormat {
        /// IEEE 754 binary16.
        Half = "half",
        /// Fixed point with the datapath's own `texel.int`, `texel.frac`.
        Q = "q",
        /// 8 bits, c/255.
        Unorm8 = "unorm8",
        /// Shared exponent: three 9-bit mantissas, one 5-bit exponent.
        Rgb9e5 = "rgb9e5",
    } default Half
}
