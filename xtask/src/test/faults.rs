//! Finds the failed tests in the output of a step.

/// Most lines that the table shows of one step.
const MOST: usize = 12;

/// The names of the failed tests of cargo, pytest and Node.js. Without one, the last error.
pub fn of(output: &str) -> Vec<String> {
    let plain = without_colours(output);
    let mut names: Vec<String> = Vec::new();
    for name in plain.lines().filter_map(test) {
        if !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }
    if names.is_empty() {
        let mut errors = plain.lines().filter(|line| line.starts_with("error"));
        return vec![errors.next_back().unwrap_or("ended without a message").to_owned()];
    }
    let beyond = names.len().saturating_sub(MOST);
    names.truncate(MOST);
    names.extend((beyond > 0).then(|| format!("and {beyond} more")));
    names
}

/// The name of a failed test, if a line tells one.
fn test(line: &str) -> Option<&str> {
    if let Some(name) = line.strip_prefix("test ").and_then(|rest| rest.strip_suffix(" ... FAILED")) {
        return Some(name);
    }
    if let Some(rest) = line.strip_prefix("FAILED ").or_else(|| line.strip_prefix("ERROR ")) {
        return rest.starts_with("tests/").then(|| rest.split(" - ").next().unwrap_or(rest));
    }
    let name = line.trim_start().strip_prefix("✖ ")?;
    // Node.js adds the time to each test, and none to its headings.
    name.ends_with("ms)").then(|| name.rsplit_once(" (").map_or(name, |(name, _)| name))
}

/// A text without the codes that colour it in a terminal, from the escape to the letter `m`.
fn without_colours(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |plain, part| plain + part.split_once('m').map_or("", |(_, rest)| rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failed_tests_are_named_once() {
        let cargo =
            "test a::b ... ok\ntest a::c ... \u{1b}[31mFAILED\u{1b}[0m\nfailures:\n    a::c\nerror: test failed\n";
        assert_eq!(of(cargo), ["a::c"]);
        let pytest =
            "FAILED tests/usd/test_a.py::test_b[x - y] - assert 1 == 2\nERROR tests/usd/test_c.py\nERROR of ours\n";
        assert_eq!(of(pytest), ["tests/usd/test_a.py::test_b[x", "tests/usd/test_c.py"]);
        let node = "✔ opens (12ms)\n✖ closes (3.5ms)\n✖ failing tests:\n✖ closes (3.5ms)\n";
        assert_eq!(of(node), ["closes"]);
    }

    #[test]
    fn without_tests_the_last_error_is_told_and_long_lists_end() {
        assert_eq!(of("error[E1]: first\nerror: step `fmt` failed\n\nhint: run it\n"), ["error: step `fmt` failed"]);
        assert_eq!(of("killed"), ["ended without a message"]);
        let many: String = (0..20).map(|i| format!("test t{i} ... FAILED\n")).collect();
        assert_eq!(of(&many).last().map(String::as_str), Some("and 8 more"));
    }
}
