//! Joins template, style, scripts and data into one page, which `Report::write` writes. The page
//! runs only these scripts, and loads nothing.

use anyhow::{Context, Result};
use serde::Serialize;

const TEMPLATE: &str = include_str!("../../assets/report.html");
const STYLE: &str = include_str!("../../assets/report.css");
const PLOTLY: &str = include_str!("../../assets/plotly/plotly.min.js");
const THREE: &str = include_str!("../../assets/three/three.min.js");
const SCRIPTS: [&str; 15] = [
    include_str!("../../assets/data.js"),
    include_str!("../../assets/plots.js"),
    include_str!("../../assets/tracking.js"),
    include_str!("../../assets/path.js"),
    include_str!("../../assets/robustness.js"),
    include_str!("../../assets/worlds.js"),
    include_str!("../../assets/recorded.js"),
    include_str!("../../assets/signals.js"),
    include_str!("../../assets/stability.js"),
    include_str!("../../assets/energy.js"),
    include_str!("../../assets/surrogate.js"),
    include_str!("../../assets/page.js"),
    include_str!("../../../machine-page/drawing.js"),
    include_str!("../../../machine-page/kinematics.js"),
    include_str!("../../assets/animation.js"),
];

/// The page with `data` in it.
pub fn html(data: &impl Serialize) -> Result<String> {
    // Inside a script element only `</` could end it; `<` is written as its escape.
    let json = serde_json::to_string(data)?.replace('<', "\\u003c");
    // They are one plain script, without modules.
    let scripts = SCRIPTS.join("\n").replace("\nexport ", "\n");
    let parts = [
        ("/*STYLE*/", STYLE),
        ("/*PLOTLY*/", PLOTLY),
        ("/*THREE*/", THREE),
        ("/*DATA*/", &json),
        ("/*SCRIPTS*/", &scripts),
    ];
    let mut page = String::with_capacity(PLOTLY.len() + THREE.len() + json.len() + (1 << 17));
    let mut rest = TEMPLATE;
    for (mark, content) in parts {
        let (before, after) = rest
            .split_once(mark)
            .with_context(|| format!("the template has no {mark} here"))?;
        page.push_str(before);
        page.push_str(content);
        rest = after;
    }
    page.push_str(rest);
    page_files::with_policy(&page).context("the template declares no encoding")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_loads_nothing_and_data_cannot_end_its_script() {
        let page = html(&"</script><b>").unwrap();
        assert!(page.contains("\\u003c/script>\\u003cb>"));
        let template = [TEMPLATE, STYLE, &SCRIPTS.concat()].concat();
        for loading in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!template.contains(loading), "{loading}");
        }
    }
}
