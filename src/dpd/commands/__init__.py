"""Commands: one module for each group of them; `dpd.commands.parser` joins the groups."""
