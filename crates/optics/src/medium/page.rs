//! A page of the database as a tree. The pages that come with this crate are read without a reader of YAML: the database
//! writes all of them alike, and the module of the web page, which holds nothing but these, is a twentieth smaller for it.
//! A test reads every page both ways.

/// A page of the database is a mapping; these are its parts that matter here.
pub(super) enum Node {
    /// Text, and the line on which its content starts.
    Scalar(String, usize),
    List(Vec<Node>, usize),
    Map(Vec<(String, Node)>, usize),
}

impl Node {
    pub(super) fn line(&self) -> usize {
        match self {
            Node::Scalar(_, line) | Node::List(_, line) | Node::Map(_, line) => *line,
        }
    }

    pub(super) fn get(&self, key: &str) -> Option<&Node> {
        match self {
            Node::Map(entries, _) => entries.iter().find(|(name, _)| name == key).map(|(_, node)| node),
            _ => None,
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Node::Scalar(text, _) => Some(text),
            _ => None,
        }
    }
}

/// Spaces before the text of a block of prose, and of a block in an entry of DATA.
const PROSE: usize = 4;
const ROWS: usize = 8;

type Lines<'a> = std::iter::Peekable<std::iter::Enumerate<std::str::Lines<'a>>>;

/// What a medium is made of: the keys REFERENCES, COMMENTS and DATA.
pub(super) fn tree(page: &str) -> Node {
    let mut lines = page.lines().enumerate().peekable();
    let mut keys = Vec::new();
    while let Some((place, line)) = lines.next() {
        match line.trim_end() {
            "DATA:" => keys.push(("DATA".to_owned(), Node::List(entries(&mut lines), place + 2))),
            "REFERENCES: |" => keys.push(("REFERENCES".to_owned(), block(&mut lines, PROSE))),
            "COMMENTS: |" => keys.push(("COMMENTS".to_owned(), block(&mut lines, PROSE))),
            // Comments, and what else is known of a sample.
            _ => {}
        }
    }
    Node::Map(keys, 1)
}

fn entries(lines: &mut Lines<'_>) -> Vec<Node> {
    let mut found: Vec<(Vec<(String, Node)>, usize)> = Vec::new();
    while let Some((place, line)) = lines.next_if(|(_, line)| line.starts_with("  ")) {
        let first = line.strip_prefix("  - ");
        if first.is_some() {
            found.push((Vec::new(), place + 1));
        }
        let pair = first.unwrap_or(line).split_once(':');
        let (Some((key, value)), Some((entry, _))) = (pair, found.last_mut()) else { continue };
        let value = match value.trim() {
            "|" => block(lines, ROWS),
            value => Node::Scalar(value.to_owned(), place + 1),
        };
        entry.push((key.trim().to_owned(), value));
    }
    found.into_iter().map(|(entry, line)| Node::Map(entry, line)).collect()
}

/// The lines that are set in by so much, without that.
fn block(lines: &mut Lines<'_>, indent: usize) -> Node {
    let first = lines.peek().map_or(0, |(place, _)| place + 1);
    let inside =
        |line: &str| line.trim().is_empty() || line.bytes().take(indent).filter(|b| *b == b' ').count() == indent;
    let mut text = String::new();
    while let Some((_, line)) = lines.next_if(|(_, line)| inside(line)) {
        text.push_str(line.get(indent..).unwrap_or_default());
        text.push('\n');
    }
    Node::Scalar(text, first)
}
