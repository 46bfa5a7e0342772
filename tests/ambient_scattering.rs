//! What `ambient_scattering` computes on the host: tubes, radii and albedos.
#![allow(clippy::unwrap_used)]

mod common;

use tyndall::technique::ambient_scattering::slab::Slab;

#[test]
fn print_slab() {
    for g in [-0.8, 0.0, 0.9] {
        let s = Slab::new(0.9, g);
        for tau in [0.25, 0.5, 1.0, 2.0, 4.0, 8.0] {
            println!("{g} {tau} {:.5}", (-tau * s.dimming(tau)).exp());
        }
    }
}

#[test]
fn print_table() {
    use tyndall::technique::ambient_scattering::table::{optics::unscattered, shipped};
    for g in [-0.8, 0.5] {
        let s = shipped().unwrap().slice(g, 0.9);
        for d in [0.1, 0.25, 0.5, 1.0, 4.0] {
            let v: Vec<_> = [0.0, 1.0, 2.0, 3.0, 3.14159]
                .iter()
                .map(|t| format!("{:.5}", s.radiance(*t, d) - unscattered(*t, d, g)))
                .collect();
            println!("{g} {d} {}", v.join(" "));
        }
    }
}
