"""The page of results: one HTML file with tables, charts and views in space, and all rows behind them."""

FILE_NAME = "report.html"
