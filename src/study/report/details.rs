//! What a report shows of chosen rows: pictures, error map, ladder, register errors, footprints.
//!
//! [`gather`] renders a row once more and puts everything into one JSON object; `section` needs nothing else.

use rtl_model::regs::Reg;
use serde_json::{Value, json};

use super::footprint::draw;
use super::svg::Svg;
use super::{setting, text};
use crate::cube::CubeMap;
use crate::engine::Rung;
use crate::engine::probe::{FloatProbe, RtlProbe, rtl};
use crate::engine::rtl::RtlEngine;
use crate::engine::tex_subject::TexEngine;
use crate::error::InputError;
use crate::image::write::write_png;
use crate::picture::Picture;
use crate::reference::{Env, PlanarTexture, Prepared, env, tex::tex};
use crate::report::error_map::{colour_of_steps, error_map};
use crate::report::escape::{base64, escape};
use crate::report::metrics;
use crate::report::table::significant;
use crate::settings::Settings;
use crate::srgb::{srgb_decode, srgb_encode};
use crate::stage::Stage;
use crate::study::bench::{Bench, Measuring, Scene};
use crate::unit::{UnitSpec, check};

/// Texels along a footprint view's side.
const WINDOW: [usize; 2] = [8, 28];

/// Renders a row once more.
///
/// # Errors
/// The unit is refused, or pictures that cannot be compared.
pub fn gather(
    bench: &mut Bench,
    row: &Value,
    spec: &UnitSpec,
    settings: &Settings,
    how: &Measuring,
    pixels: &[[u32; 2]],
) -> Result<Value, InputError> {
    let (rendering, ..) = bench.render(spec, settings, true)?;
    let mut pictures = vec![("the unit", png(&rendering.picture, how.exposure))];
    let mut ladder = Vec::new();
    let mut above = (Rung::Rtl, rendering.picture.clone());
    let mut worst = [0, 0];
    for rung in [Rung::F64, Rung::Ewa, Rung::Truth] {
        if rung == Rung::Truth && !how.against.contains(&rung) {
            continue;
        }
        let below = bench.reference_picture(rung, settings, &how.truth).clone();
        let pair = metrics::compare(&above.1, &below, how.exposure)?;
        if rung == Rung::F64 {
            worst = pair.worst_pixel;
            pictures.push(("f64", png(&below, how.exposure)));
            let map = error_map(&above.1, &below, how.exposure)?;
            pictures.push(("difference, 8-bit steps", png(&map, 0.0)));
        }
        ladder.push(pair.to_json(above.0.name(), rung.name()));
        above = (rung, below);
    }
    if let Some(picture) = counts(bench) {
        pictures.push(("probes, dark 1, white most", png(&picture, 0.0)));
    }
    if let (Scene::Hit(s), Some(searches)) = (bench.scene(), &rendering.searches) {
        let pixels = s.scene.rays.iter().map(|r| r.pixel);
        let size = [s.scene.width, s.scene.height];
        let numbers = searches.iterations.iter().map(|n| f64::from(*n));
        pictures.push((
            "look-ups, dark 0, white most",
            png(&ramp(size, pixels.zip(numbers)), 0.0),
        ));
    }
    if let Some(used) = &rendering.texture_use {
        pictures.push(("levels of detail", png(&used.levels, 0.0)));
    }
    let parts = attribution(bench, spec, settings, how)?;
    let mut wanted: Vec<[u32; 2]> = pixels.to_vec();
    if wanted.is_empty() {
        wanted = vec![worst, longest(bench, settings, how).unwrap_or(worst)];
        wanted.dedup();
    }
    let views: Vec<Value> = wanted
        .iter()
        .filter_map(|pixel| view(bench.scene(), spec, settings, *pixel).transpose())
        .collect::<Result<_, _>>()?;
    let pictures: Vec<Value> = pictures
        .into_iter()
        .map(|(name, png)| json!({"name": name, "png": base64(&png)}))
        .collect();
    Ok(
        json!({"row": row["row"], "scene": row["scene"], "set": row["set"], "command": row["command"],
        "pictures": pictures, "ladder": ladder, "attribution": parts, "footprints": views}),
    )
}

fn png(picture: &Picture, exposure: f64) -> Vec<u8> {
    let mut out = Vec::new();
    // Memory takes everything; a picture without pixels gives no file.
    let _ = write_png(&mut out, picture, exposure, &[]);
    out
}

/// Numbers from dark to white by their share of the largest.
fn ramp(size: [usize; 2], numbers: impl Iterator<Item = ([u32; 2], f64)>) -> Picture {
    let numbers: Vec<([u32; 2], f64)> = numbers.collect();
    let most = numbers.iter().fold(1.0f64, |most, (_, n)| most.max(*n));
    let mut picture = Picture::new(size[0], size[1]);
    picture.rgb.fill([0.1; 3]);
    for ([x, y], n) in numbers {
        let at = usize::try_from(y).unwrap_or(0) * size[0] + usize::try_from(x).unwrap_or(0);
        if picture.covered[at] {
            continue;
        }
        picture.covered[at] = true;
        let colour = colour_of_steps(libm::exp2(16.0 * n / most - 8.0));
        picture.rgb[at] = colour.map(|c| srgb_decode(f64::from(c) / 255.0));
    }
    picture
}

/// Probes of each pixel's first request.
fn counts(bench: &Bench) -> Option<Picture> {
    let (pixels, size): (Vec<[u32; 2]>, _) = match bench.scene() {
        Scene::Env(s) => (
            s.scene.fragments.iter().map(|f| f.pixel).collect(),
            [s.scene.width, s.scene.height],
        ),
        Scene::Hit(s) => (
            s.scene.rays.iter().map(|r| r.pixel).collect(),
            [s.scene.width, s.scene.height],
        ),
        Scene::Tex(_) => return None,
    };
    let mut probes = Vec::new();
    bench.lines(&mut |line| probes.push(line.probes as f64));
    Some(ramp(size, pixels.into_iter().zip(probes)))
}

/// The pixel with the longest probe line of several probes.
fn longest(bench: &mut Bench, settings: &Settings, how: &Measuring) -> Option<[u32; 2]> {
    let lines = bench.reference_lines(settings, &how.truth).to_vec();
    let best = lines
        .iter()
        .enumerate()
        .filter(|(_, l)| (4..=12).contains(&l.probes));
    let (index, _) = best.max_by(|a, b| {
        (a.1.texels[0] / a.1.texels[1].max(1.0))
            .total_cmp(&(b.1.texels[0] / b.1.texels[1].max(1.0)))
    })?;
    match bench.scene() {
        Scene::Env(s) => s.scene.fragments.get(index).map(|f| f.pixel),
        Scene::Hit(s) => s.scene.rays.get(index).map(|r| r.pixel),
        Scene::Tex(_) => None,
    }
}

/// What longer words of one stage alone would buy, and larger tables: PSNR against f64.
fn attribution(
    bench: &mut Bench,
    spec: &UnitSpec,
    settings: &Settings,
    how: &Measuring,
) -> Result<Vec<Value>, InputError> {
    let mut out = Vec::new();
    let mut add = |part: &str, spec: &UnitSpec, bench: &mut Bench| -> Result<(), InputError> {
        let (rendering, ..) = bench.render(spec, settings, true)?;
        let reference = bench.reference_picture(Rung::F64, settings, &how.truth);
        let pair = metrics::compare(&rendering.picture, reference, how.exposure)?;
        out.push(json!({"part": part, "psnr_db": pair.psnr_db, "mean_lsb8": pair.mean_lsb8}));
        Ok(())
    };
    add("the unit", spec, bench)?;
    let stages = how
        .cost
        .sheet(&spec.config, bench.scene().operation())
        .stages;
    for (stage, _) in stages {
        let mut longer = spec.clone();
        for reg in Reg::ALL
            .iter()
            .filter(|reg| reg.info().stage == stage.name())
        {
            for bits in [8, 6, 4, 2, 1] {
                let mut tried = longer.clone();
                tried.config.formats[reg.index()].frac += bits;
                if check(&tried).is_ok() {
                    longer = tried;
                    break;
                }
            }
        }
        if stage == Stage::Filter {
            (longer.config.weight_bits, longer.config.lod_bits) = (8, 8);
        }
        add(stage.name(), &longer, bench)?;
    }
    let mut larger = spec.clone();
    larger.config.tables.eigen.entries = 1024;
    if check(&larger).is_ok() {
        add("angle table", &larger, bench)?;
    }
    let mut larger = spec.clone();
    let tables = &mut larger.config.tables;
    for table in [
        &mut tables.recip,
        &mut tables.rsqrt,
        &mut tables.sqrt,
        &mut tables.log2,
    ] {
        (table.entries, table.order, table.frac) = (256, 2, 26);
    }
    if check(&larger).is_ok() {
        add("other tables", &larger, bench)?;
    }
    Ok(out)
}

/// The texel of a level at a place; nothing beyond a face.
type Texel<'a> = dyn Fn(usize, [i64; 2]) -> Option<[f32; 3]> + 'a;

/// What both arithmetics put about one request, and the texture that it asks.
struct Request<'a> {
    rtl: RtlProbe,
    float: FloatProbe,
    /// u and v of the centre by f64.
    centre: [f64; 2],
    /// λ in texels of level 0.
    scale: f64,
    /// Columns and rows of a level, and its texels.
    sizes: Vec<[usize; 2]>,
    texel: Box<Texel<'a>>,
}

/// The footprint view of a pixel's first request; none where the pixel shows no fragment.
fn view(
    scene: &Scene,
    spec: &UnitSpec,
    settings: &Settings,
    pixel: [u32; 2],
) -> Result<Option<Value>, InputError> {
    let prepared = Prepared::new(settings);
    let (mut mine, mut theirs) = (RtlProbe::default(), FloatProbe::default());
    let request = match scene {
        Scene::Env(s) => {
            let Some(fragment) = s.scene.fragments.iter().find(|f| f.pixel == pixel) else {
                return Ok(None);
            };
            let engine = RtlEngine::new(spec, s.needs(), &s.map)?;
            rtl(
                &engine.unit,
                &engine.config,
                &fragment.fragment,
                Some(&engine.texture),
                &mut mine,
            );
            let found = env(
                &prepared,
                &fragment.fragment,
                s.map.size(),
                None,
                &mut theirs,
            );
            Request::on_cube(mine, theirs, &s.map, &found)
        }
        Scene::Hit(s) => {
            let Some(ray) = s.scene.rays.iter().find(|r| r.pixel == pixel) else {
                return Ok(None);
            };
            let engine =
                crate::engine::hit::HitRtl::new(spec, &s.distance, Some(&s.map), s.map.size())?;
            engine.trace(&ray.fragment, &mut mine);
            let Some(found) = s.reference(settings).trace(&ray.fragment, &mut theirs).env else {
                return Ok(None);
            };
            Request::on_cube(mine, theirs, &s.map, &found)
        }
        Scene::Tex(s) => {
            let engine = TexEngine::new(spec, s)?;
            let [column, row] = pixel.map(|n| usize::try_from(n).unwrap_or(0));
            let mut first = None;
            if row < s.scene.height {
                s.each_look(&engine, settings, row, &mut |x, look, words, width| {
                    if x == column && first.is_none() {
                        first = Some((*look, *words, width));
                    }
                });
            }
            let Some((look, words, width)) = first else {
                return Ok(None);
            };
            let unit = &engine.textures[look.texture];
            unit.lanes::<1, _>(std::slice::from_ref(&words), &mut mine);
            let map = &s.scene.textures[look.texture];
            let wrap = settings.tex.wrap;
            let planar = PlanarTexture::new(map, wrap);
            let found = tex(
                &prepared,
                width,
                &look.fragment,
                map.size(),
                Some(&planar),
                &mut theirs,
            );
            let texel = move |level: usize, at: [i64; 2]| {
                let level = &map.levels[level];
                let [x, y] = [0, 1].map(|i| wrap[i].texel(at[i], level.size[i]));
                Some(level.texel(x, y))
            };
            let sizes = map.levels.iter().map(|l| l.size).collect();
            Request {
                rtl: mine,
                float: theirs,
                centre: found.centre,
                scale: 1.0,
                sizes,
                texel: Box::new(texel),
            }
        }
    };
    Ok(Some(request.view(pixel)))
}

impl<'a> Request<'a> {
    /// A request to a cube map; the float reference found its footprint.
    fn on_cube(rtl: RtlProbe, float: FloatProbe, map: &'a CubeMap, found: &Env) -> Self {
        let face = found.face;
        let texel = move |level: usize, at: [i64; 2]| {
            let level = &map.levels[level];
            let place = at.map(|x| usize::try_from(x).ok().filter(|x| *x < level.size));
            Some(level.texel(face, place[0]?, place[1]?))
        };
        Self {
            rtl,
            float,
            centre: [found.u, found.v],
            scale: map.size() as f64 / 2.0,
            sizes: map.levels.iter().map(|l| [l.size; 2]).collect(),
            texel: Box::new(texel),
        }
    }
}

impl Request<'_> {
    fn float(&self, reg: Reg, component: usize) -> f64 {
        self.float.get(reg).get(component).copied().unwrap_or(0.0)
    }

    fn mine(&self, reg: Reg, component: usize) -> f64 {
        self.rtl.get(reg).get(component).map_or(0.0, |c| c.value())
    }

    /// Everything in texels of the level that f64's level of detail rounds down to.
    fn view(&self, pixel: [u32; 2]) -> Value {
        let lod = self.float(Reg::FootLod, 0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a level, clamped to the chain"
        )]
        let level = (lod.max(0.0) as usize).min(self.sizes.len() - 1);
        let size = self.sizes[level];
        let shrink = libm::exp2(-(level as f64));
        let texel = |uv: [f64; 2]| [0, 1].map(|i| (uv[i] + 1.0) / 2.0 * size[i] as f64);
        let centre = texel(self.centre);
        let length = self.float(Reg::FootLength, 0) * shrink;
        let minor = self.float(Reg::EigenLambda, 1) * self.scale * shrink;
        let probes = |count: usize, step: [f64; 2]| -> Vec<[f64; 2]> {
            (0..count)
                .map(|i| {
                    let along = 2.0 * i as f64 + 1.0 - count as f64;
                    texel([0, 1].map(|c| self.centre[c] + along * step[c]))
                })
                .collect()
        };
        let exact_probes = probes(
            self.float.get(Reg::AddrU).len(),
            [0, 1].map(|c| self.float(Reg::FootStep, c)),
        );
        let mine = probes(
            self.rtl.get(Reg::AddrU).len(),
            [0, 1].map(|c| self.mine(Reg::FootStep, c)),
        );
        let exact = [0, 1].map(|c| self.float(Reg::EigenAxis, c));
        let table = [0, 1].map(|c| self.mine(Reg::EigenAxis, c));
        let sine = exact[0] * table[1] - exact[1] * table[0];
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the window's sizes"
        )]
        let side = (length * 1.3 + 4.0).clamp(WINDOW[0] as f64, WINDOW[1] as f64) as usize;
        let first = centre.map(|c| (c - side as f64 / 2.0).floor());
        let row = |y: usize| -> Vec<String> {
            (0..side)
                .map(|x| {
                    #[expect(clippy::cast_possible_truncation, reason = "texel numbers of a face")]
                    let at = [first[0] + x as f64, first[1] + y as f64].map(|c| c as i64);
                    (self.texel)(level, at).map_or("#777777".into(), hex)
                })
                .collect()
        };
        let texels: Vec<Vec<String>> = (0..side).map(row).collect();
        json!({"id": format!("{}-{}", pixel[0], pixel[1]).replace('-', ""), "pixel": pixel, "level": level, "texels": texels, "first": first, "centre": centre,
            "length": length, "minor": minor, "width": self.float(Reg::FootWidth, 0) * shrink, "exact_axis": exact, "table_axis": table,
            "probes": mine, "exact_probes": exact_probes, "off_degrees": libm::asin(sine.clamp(-1.0, 1.0)).abs().to_degrees()})
    }
}

fn hex(colour: [f32; 3]) -> String {
    let byte = |c: f32| {
        let shown = 255.0 * srgb_encode(f64::from(c).clamp(0.0, 1.0));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to 255"
        )]
        let byte = (shown + 0.5) as u8;
        byte
    };
    let [r, g, b] = colour.map(byte);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The HTML of a row's details, and its drawings.
pub(super) fn section(detail: &Value) -> (String, Vec<(String, String)>) {
    let row = text(&detail["row"]);
    let mut files = Vec::new();
    let mut out = format!(
        "<section id=\"detail-{row}\"><h2>Row {row}: {}, {}</h2>\n<pre>{}</pre>\n<div class=\"pictures\">\n",
        escape(&text(&detail["scene"])),
        escape(&setting(detail)),
        escape(&text(&detail["command"]))
    );
    for picture in detail["pictures"].as_array().into_iter().flatten() {
        let name = escape(&text(&picture["name"]));
        out += &format!(
            "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{}\"><figcaption>{name}</figcaption></figure>\n",
            text(&picture["png"])
        );
    }
    out += "</div>\n<h3>Ladder</h3>\n<table class=\"rows\"><thead><tr><th>pair</th><th>PSNR (dB)</th><th>largest (8-bit steps)</th><th>beyond one step (%)</th></tr></thead><tbody>\n";
    for pair in detail["ladder"].as_array().into_iter().flatten() {
        let number = |key: &str| {
            pair[key]
                .as_f64()
                .map_or("equal".into(), |x| significant(x, 4))
        };
        let share = pair["share_over_1_lsb8"]
            .as_f64()
            .map_or(String::new(), |x| significant(100.0 * x, 3));
        out += &format!(
            "<tr><td>{} – {}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{share}</td></tr>\n",
            text(&pair["a"]),
            text(&pair["b"]),
            number("psnr_db"),
            number("max_lsb8")
        );
    }
    out += "</tbody></table>\n";
    let bars = bars(&detail["attribution"]);
    out += &format!(
        "<figure>{bars}<figcaption>Where accuracy is lost: PSNR against f64 if the registers of one stage alone had up to eight more bits, or a table alone were large. A stage without a bar is not what limits this unit.</figcaption></figure>\n"
    );
    files.push((format!("attribution-{row}.svg"), bars));
    for view in detail["footprints"].as_array().into_iter().flatten() {
        let svg = draw(view);
        let pixel = format!("{},{}", view["pixel"][0], view["pixel"][1]);
        out += &format!(
            "<figure>{svg}<figcaption>The footprint of pixel {pixel} over the texels of level {}: the ellipse whose axes are λ1 and λ2, the exact axis in green, the unit's in red.</figcaption></figure>\n",
            view["level"]
        );
        files.push((format!("footprint-{row}-{}.svg", text(&view["id"])), svg));
    }
    (out + "</section>\n", files)
}

/// Bars: what each part would buy if it alone were longer.
fn bars(parts: &Value) -> String {
    let mut gains: Vec<(String, f64, f64)> = Vec::new();
    let db = |row: &Value| row["psnr_db"].as_f64();
    let base = parts.get(0).and_then(db).unwrap_or(0.0);
    for row in parts.as_array().into_iter().flatten().skip(1) {
        let reached = db(row).unwrap_or(base);
        gains.push((text(&row["part"]), reached - base, reached));
    }
    let most = gains.iter().fold(0.1f64, |most, g| most.max(g.1.abs()));
    let mut svg = Svg::new(560.0, 24.0 * gains.len() as f64 + 16.0);
    for (i, (part, gain, reached)) in gains.iter().enumerate() {
        let y = 10.0 + 24.0 * i as f64;
        let length = 240.0 * gain.max(0.0) / most + 1.0;
        svg.text([118.0, y + 13.0], "e", part);
        let width = super::svg::n(length);
        svg.raw(&format!(
            "<rect class=\"bar\" x=\"124\" y=\"{y}\" width=\"{width}\" height=\"16\"/>"
        ));
        // No minus in front of nothing.
        let gain = if gain.abs() < 0.005 { 0.0 } else { *gain };
        let label = format!("{gain:+.2} dB, to {reached:.2}");
        svg.text([132.0 + length, y + 13.0], "s", &label);
    }
    svg.finish("what longer words of each stage would buy")
}
