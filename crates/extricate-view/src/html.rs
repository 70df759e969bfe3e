//! The page as a file: scripts and data in one HTML file.

use extricate::Solver;
use extricate::parts::Visual;
use serde::Serialize;

use crate::answer_data::AnswerData;
use crate::live::Live;
use crate::scene_data::{SceneData, scene_data};

const SKELETON: &str = include_str!("../page/page.html");
const STYLE: &str = include_str!("../page/style.css");
const THREE: &str = include_str!("../page/three/three.min.js");
const THREE_LICENCE: &str = include_str!("../page/three/LICENSE");
/// The scripts in the order of their dependencies.
const SCRIPTS: [&str; 14] = [
    include_str!("../page/words.js"),
    include_str!("../page/data.js"),
    include_str!("../page/kinematics.js"),
    include_str!("../page/stage.js"),
    include_str!("../page/view.js"),
    include_str!("../page/slice.js"),
    include_str!("../page/panel.js"),
    include_str!("../page/share.js"),
    include_str!("../page/plot.js"),
    include_str!("../page/tree.js"),
    include_str!("../page/play.js"),
    include_str!("../page/controls.js"),
    include_str!("../page/live.js"),
    include_str!("../page/main.js"),
];
/// Beginning of every page, by which pages are recognised.
const HEAD: &str = "<!doctype html><!-- a page of extricate -->";

/// Contents of a page.
pub struct Page<'a> {
    /// Heading of the page.
    pub title: &'a str,
    /// Describes in words how the page was made.
    pub made: &'a str,
    /// Queries and their answers, in order.
    pub answers: &'a [AnswerData],
    /// Whether the answers are frames of a motion, which are played one after the other.
    pub is_stream: bool,
    /// How links look; empty if that is not known.
    pub visuals: &'a [Visual],
    /// The library for a live page, if there is one.
    pub live: Option<&'a Live>,
}

#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    made: &'a str,
    scene: SceneData<'a>,
    answers: &'a [AnswerData],
    stream: bool,
    live: Option<&'a Live>,
}

impl Page<'_> {
    /// Renders the page as one HTML file that loads nothing from elsewhere.
    ///
    /// # Errors
    /// Fails if the data cannot be written as JSON, which no value of this crate causes.
    pub fn html(&self, solver: &Solver) -> serde_json::Result<String> {
        let data = Data {
            title: self.title,
            made: self.made,
            scene: scene_data(solver, self.visuals),
            answers: self.answers,
            stream: self.is_stream,
            live: self.live,
        };
        let filled = [
            ("{{style}}", STYLE.to_string()),
            ("{{licence}}", THREE_LICENCE.to_string()),
            ("{{three}}", in_script(THREE)),
            ("{{data}}", json_in_script(&serde_json::to_string(&data)?)),
            ("{{scripts}}", in_script(&SCRIPTS.concat())),
        ];
        Ok(format!("{HEAD}\n{}", fill(SKELETON, &filled)))
    }
}

/// Style of a page without a 3D view.
const PLAIN_STYLE: &str = "body { font: 15px/1.5 system-ui, sans-serif; color: #1b2430; max-width: 940px; margin: 24px auto; \
    padding: 0 16px } h1 { font-size: 22px } h2 { font-size: 16px; margin: 18px 0 4px } .verdict { font-size: 17px } \
    .plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(340px, 1fr)); gap: 12px 28px } figure { margin: 0 } \
    figcaption { color: #55606e; font-size: 13px } svg { width: 100% } table { border-collapse: collapse } \
    th { text-align: left; font-weight: 600; padding-right: 16px; vertical-align: top } td, th { padding-top: 3px }";

/// Renders a page of text and plots. `body` is HTML, in which names are [`escaped`].
pub fn document(title: &str, body: &str) -> String {
    let title = escaped(title);
    format!(
        "{HEAD}\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title} \u{2013} extricate</title>\n<style>{PLAIN_STYLE}</style>\n</head>\n\
         <body>\n{body}<footer>extricate {}</footer>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    )
}

/// Escapes text, so that no browser takes it for markup.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Whether a file that begins with `head` is a page of this crate.
pub fn is_page(head: &[u8]) -> bool {
    head.starts_with(HEAD.as_bytes())
}

/// Fills each place of the skeleton. Text that fills one place is not searched for others.
fn fill(skeleton: &str, places: &[(&str, String)]) -> String {
    let mut out = String::new();
    let mut rest = skeleton;
    while let Some((at, name, text)) =
        places.iter().filter_map(|(name, text)| Some((rest.find(name)?, *name, text))).min_by_key(|found| found.0)
    {
        out.push_str(&rest[..at]);
        out.push_str(text);
        rest = &rest[at + name.len()..];
    }
    out + rest
}

/// Escapes the text of a script, so that it does not end the element.
fn in_script(text: &str) -> String {
    text.replace("</script", "<\\/script").replace("<!--", "<\\!--")
}

/// Escapes JSON without changing its meaning, so that no browser takes names in it for HTML.
fn json_in_script(json: &str) -> String {
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_filled_once() {
        let places = [("{{a}}", "{{b}}".to_string()), ("{{b}}", "1".to_string())];
        assert_eq!(fill("x {{a}} y {{b}} z {{a}}", &places), "x {{b}} y 1 z {{b}}");
    }

    #[test]
    fn names_cannot_end_the_script_that_holds_them() {
        let name = "</script><script>alert(1)</script><!--";
        let text = json_in_script(&serde_json::to_string(name).unwrap());
        assert!(!text.contains('<'), "{text}");
        assert_eq!(serde_json::from_str::<String>(&text).unwrap(), name);
    }

    #[test]
    fn a_page_is_whole_and_asks_for_nothing() {
        let solver = Solver::new(extricate::builtin::scene("planar-arm").unwrap());
        let page = Page { title: "<b>", made: "by a test", answers: &[], is_stream: false, visuals: &[], live: None };
        let page = page.html(&solver).unwrap();
        assert!(is_page(page.as_bytes()) && page.ends_with("</html>\n"));
        assert!(!page.contains("{{"), "a place is empty");
        assert!(page.contains("Copyright") && page.contains("three.js authors"));
        let own = page.replace(&in_script(THREE), "");
        for word in ["src=", "http://", "https://", "@import", "fetch(", "url("] {
            assert!(!own.contains(word), "{word}");
        }
    }
}
