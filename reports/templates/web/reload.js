// A list that is made anew when the book has a new entry.
import { onChange } from "/static/common.js";

onChange(() => location.reload());
