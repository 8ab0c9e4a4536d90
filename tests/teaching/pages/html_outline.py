"""What a page holds, read with Python's own HTML parser."""

from html.parser import HTMLParser

ALONE = {"meta", "link", "input", "br", "img", "circle", "path"}  # elements without an end


class Outline(HTMLParser):
    """Ids, links, elements and text of a page; an element that is not closed as it was opened is an error."""

    def __init__(self, page):
        super().__init__()
        self.ids, self.links, self.loaded, self.elements, self.words, self._open = [], [], [], [], [], []
        self.feed(page)
        self.close()
        assert self._open == [], f"never closed: {self._open}"

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.elements.append((tag, found))
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found["href"]] if tag == "a" else []
        self.loaded += [value for name, value in attributes if name == "src" or (name == "href" and tag == "link")]
        if tag not in ALONE:
            self._open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self._open, f"</{tag}> closes nothing"
        assert self._open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data):
        if not {"style", "script"} & set(self._open):
            self.words.append(data)

    @property
    def text(self):
        """The page's words, with single spaces."""
        return " ".join(" ".join(self.words).split())

    def count(self, tag):
        """How many elements of that name there are."""
        return sum(name == tag for name, _ in self.elements)
