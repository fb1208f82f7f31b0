//! HTML pages of results that open offline: escaping of text, and the frame and style of every page.

/// Colours, page, headings and cells. A page adds its own rules.
const STYLE: &str = "
:root{color-scheme:light dark;--ink:light-dark(#182028,#e8ebee);--muted:light-dark(#55616d,#9eabb8);--ground:light-dark(#fff,#0f1318);
--line:light-dark(#d5dbe1,#2a333e)}
body{max-width:1080px;margin:24px auto;padding:0 16px;font:14px/1.45 system-ui,sans-serif;font-variant-numeric:tabular-nums;
color:var(--ink);background:var(--ground)}
h1{font-size:20px}h2{font-size:16px;margin-top:28px}table{border-collapse:collapse}
th,td{padding:4px 10px 4px 0;border-bottom:1px solid var(--line)}th{color:var(--muted);font-weight:400}
svg{max-width:100%;height:auto;border-radius:6px}
";

/// `text` escaped for HTML, for use between elements and in quoted attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A page: `title` is plain text, `style` contains additional CSS rules, `body` is markup.
pub fn page(title: &str, style: &str, body: &str) -> String {
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{}</title><style>{STYLE}{style}</style></head><body>{body}</body></html>\n",
        escaped(title)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_scenario_cannot_become_markup() {
        assert_eq!(escaped("<b a=\"1\">&"), "&lt;b a=&quot;1&quot;&gt;&amp;");
        let page = page("</title>", "", "<p>body</p>");
        assert!(page.contains("<title>&lt;/title&gt;</title>") && page.contains("<p>body</p>"));
    }
}
