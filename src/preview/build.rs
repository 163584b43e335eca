//! Embeds the page of the preview, which `cargo xtask page` bundles into `page/dist`. Without it, empty files take its
//! place, and `usdtailor preview` says how to make it.

use std::path::Path;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=page/dist");
    let from = Path::new("page/dist");
    let to = Path::new(&env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("page");
    fs::create_dir_all(&to).expect("the output folder can be made");
    for name in ["index.html", "page.js", "page.css"] {
        let content = fs::read(from.join(name)).unwrap_or_default();
        fs::write(to.join(name), content).expect("the page can be copied");
    }
}
